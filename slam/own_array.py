"""Numbers that code of the user's own returns, checked before anything computes with them."""

from __future__ import annotations

from math import isfinite
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.errors import InputError
from slam.named_code import kind_of


def expect_array(what: str, value: Any, shape: tuple[int | None, ...], kind: type[float] = float) -> NDArray[Any]:
    """Return the array with this kind of numbers, ``float`` or ``int``; None in the shape stands for any length.

    InputError, which begins with ``what``, where the shape or the kind is another, or a number is not finite.
    """
    if not isinstance(value, np.ndarray) or not _fits(value.shape, shape):
        found = f"of shape {value.shape}" if isinstance(value, np.ndarray) else f"of type {kind_of(value)}"
        wanted = str(shape).replace("None", "K")
        raise InputError(f"{what} is {found}, not an array of shape {wanted}; see docs/extend.md")
    if value.size and value.dtype.kind not in ("iu" if kind is int else "iuf"):
        numbers = "whole numbers" if kind is int else "numbers"
        raise InputError(f"{what} is an array of {value.dtype}, not of {numbers}; see docs/extend.md")
    array = np.ascontiguousarray(value, kind)
    for place in np.argwhere(~np.isfinite(array)):
        raise InputError(f"{what}[{', '.join(map(str, place))}] is {array[tuple(place)]}, not a finite number")
    return array


def expect_numbers(what: str, value: Any, names: tuple[str, ...]) -> None:
    """Require that these attributes are finite numbers; InputError begins with ``what`` and names the first other."""
    for name in names:
        number = getattr(value, name)
        if not isinstance(number, Real) or not isfinite(number):
            raise InputError(f"{what}{name} is {number!r}, not a finite number; see docs/extend.md")


def _fits(shape: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    return len(shape) == len(wanted) and all(b in (None, a) for a, b in zip(shape, wanted, strict=True))
