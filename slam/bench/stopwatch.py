"""Wall time of a function, and times as text."""

from collections.abc import Callable
from time import perf_counter

import numpy as np

from slam.pose import FloatArray


def seconds(function: Callable[[], object]) -> float:
    """Time one call, in seconds."""
    began = perf_counter()
    function()
    return perf_counter() - began


def median_seconds(function: Callable[[], object], repeats: int) -> float:
    """Return the median time of ``repeats`` calls, after one that is not counted: it compiles, and fills the caches."""
    function()
    return float(np.median([seconds(function) for _ in range(repeats)]))


def milliseconds(times: FloatArray) -> tuple[str, str]:
    """Format median and 99th percentile of times in seconds as milliseconds."""
    return f"{1e3 * np.median(times):.3f}", f"{1e3 * np.percentile(times, 99):.2f}"


def microseconds(times: FloatArray, reference: float, digits: int = 0) -> tuple[str, str, str]:
    """Format median and 99th percentile of times in seconds as microseconds, and the median over the reference."""
    median, p99 = np.median(times), np.percentile(times, 99)
    return f"{1e6 * median:.{digits}f}", f"{1e6 * p99:.{digits}f}", f"{median / reference:.1f}"
