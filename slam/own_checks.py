"""Checks of the results of a user's own code, before they are used."""

from collections.abc import Sequence
from math import isfinite
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.errors import HopslamError, InputError


def expect(place: str, value: Any, kind: type, raises: type[HopslamError] = InputError) -> None:
    """Check that a value is of this kind; else raise ``raises``, with the place and the returned value."""
    if not isinstance(value, kind):
        raise raises(f"{place} returned {type_name(value)}, not {kind.__name__}; see docs/extend.md")


def expect_parts(place: str, value: Any, names: Sequence[str], kind: str) -> None:
    """Check that a value has the attributes of a ``kind``; InputError lists the missing ones."""
    if missing := [name for name in names if not hasattr(value, name)]:
        fault = f"{type_name(value)} has no {', '.join(missing)}"
        raise InputError(f"{place} is not a valid {kind}: {fault}; see docs/extend.md")


def type_name(value: Any) -> str:
    """Describe the type of a value for a user."""
    return "None" if value is None else type(value).__name__


def expect_array(what: str, value: Any, shape: tuple[int | None, ...], kind: type[float] = float) -> NDArray[Any]:
    """Return the array with this kind of numbers, ``float`` or ``int``; None in the shape stands for any length.

    InputError, which begins with ``what``, for another shape or kind, or a number that is not finite.
    """
    if not isinstance(value, np.ndarray) or not _fits(value.shape, shape):
        found = f"of shape {value.shape}" if isinstance(value, np.ndarray) else f"of type {type_name(value)}"
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
    """Check that these attributes are finite numbers; InputError begins with ``what`` and names one that is not."""
    for name in names:
        number = getattr(value, name)
        if not isinstance(number, Real) or not isfinite(number):
            raise InputError(f"{what}{name} is {number!r}, not a finite number; see docs/extend.md")


def _fits(shape: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    return len(shape) == len(wanted) and all(b in (None, a) for a, b in zip(shape, wanted, strict=True))
