"""How the hot loops are compiled: numba, cached beside the source, sums free to be vectorised."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

_FASTMATH = {"reassoc", "contract", "nsz", "arcp"}
F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile an array function ahead of its second call; the result is kept on disk for the next process.

    Additions may be reordered and a division by zero gives infinity, which lets the compiler use vector registers; a
    NaN stays a NaN. On one machine the same input gives the same bits. The kept result is renewed when the function's
    own file changes, and only then: a compiled function calls compiled functions of its own file, and of no other.
    """
    return _compile(function, parallel=False)


def compiled_parallel(function: F) -> F:
    """The same, with the turns of each ``prange`` shared out among the processors."""
    return _compile(function, parallel=True)


def _compile(function: F, parallel: bool) -> F:
    options: dict[str, Any] = {"error_model": "numpy", "fastmath": _FASTMATH, "parallel": parallel}
    try:
        return cast(F, njit(cache=True, **options)(function))
    except RuntimeError:  # neither beside the source nor at home is there a place to keep it
        return cast(F, njit(**options)(function))
