"""Scans in the order of their stamps."""

from bisect import bisect_left
from collections.abc import Sequence
from typing import Protocol, TypeVar

from slam.files.logs.read_statistics import ReadStatistics


class Stamped(Protocol):
    """A scan line: its number in the file and its time in seconds."""

    @property
    def line(self) -> int: ...
    @property
    def stamp(self) -> float: ...


Row = TypeVar("Row", bound=Stamped)


def in_order(rows: Sequence[Row], statistics: ReadStatistics) -> list[Row]:
    """The rows without the fewest that must go for the stamps to increase strictly."""
    kept = set(longest_increasing([row.stamp for row in rows]))
    for index, row in enumerate(rows):
        if index not in kept:
            statistics.skip("stamp not increasing", row.line)
    return [rows[index] for index in sorted(kept)]


def longest_increasing(values: Sequence[float]) -> list[int]:
    """Indices of a longest strictly increasing subsequence; of equal neighbours the first stays.

    Patience sorting (Fredman 1975), n log n: ``ends[k]`` is where the run of k + 1 values with the smallest end ends.
    One garbled stamp far in the future so costs one scan, and not all that follow.
    """
    tops: list[float] = []
    ends: list[int] = []
    before: list[int] = []
    for index, value in enumerate(values):
        k = bisect_left(tops, value)
        before.append(ends[k - 1] if k else -1)
        if k == len(tops) or value < tops[k]:
            tops[k : k + 1], ends[k : k + 1] = [value], [index]
    run, last = [], ends[-1] if ends else -1
    while last >= 0:
        run.append(last)
        last = before[last]
    return run[::-1]
