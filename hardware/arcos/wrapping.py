"""Counters that begin anew: how far one really went between two readings."""


def unwrapped_step(before: float, after: float, wrap: float) -> float:
    """The step of least size from one reading to the next, both modulo ``wrap``; within +-wrap / 2."""
    return (after - before + wrap / 2.0) % wrap - wrap / 2.0
