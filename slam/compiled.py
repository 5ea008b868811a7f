"""How the hot loops are compiled: numba, cached beside the source, sums free to be vectorised."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile an array function ahead of its second call; the result is kept on disk for the next process.

    Additions may be reordered, which lets the compiler use vector registers; a NaN stays a NaN. On one machine the same
    input gives the same bits.
    """
    return cast(F, njit(cache=True, fastmath={"reassoc", "contract", "nsz", "arcp"})(function))
