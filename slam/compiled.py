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
    While one runs, other threads run too.
    """
    try:
        return cast(F, njit(cache=True, nogil=True, error_model="numpy", fastmath=_FASTMATH)(function))
    except RuntimeError:  # neither beside the source nor at home is there a place to keep it
        return cast(F, njit(nogil=True, error_model="numpy", fastmath=_FASTMATH)(function))
