"""Wall time of a function."""

from collections.abc import Callable
from time import perf_counter

import numpy as np


def seconds(function: Callable[[], object]) -> float:
    """Time one call, in seconds."""
    began = perf_counter()
    function()
    return perf_counter() - began


def median_seconds(function: Callable[[], object], repeats: int) -> float:
    """Median over so many calls, after one that is not counted: it compiles, and fills the caches."""
    function()
    return float(np.median([seconds(function) for _ in range(repeats)]))
