"""Makes stamps increase: repairs equal, zero and garbled ones, and corrects clock steps, in the order of the file.

The order of a file is taken as the true one, whatever the clock; so no scan is dropped because of its stamp.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from itertools import groupby
from statistics import median_low
from typing import Final, NamedTuple, Protocol, TypeVar

import numpy as np

from slam.files.logs.read_statistics import ReadStatistics
from slam.pose import FloatArray

_INTERVAL: Final = 0.1
"""Seconds between two scans if unknown: most lidars turn ten times a second."""
_RUN: Final = 3
"""Number of increasing stamps, all earlier than the ones before them, that show a clock that was set back. Fewer are
taken as garbled."""
_LATE: Final = 1.0
"""Largest variation of the delay from a stamp to its receipt, seconds."""


class StampedScan(Protocol):
    """A scan in a file: its index, its time in seconds, and the hash of its readings."""

    @property
    def line(self) -> int: ...
    @property
    def stamp(self) -> float: ...
    @property
    def fingerprint(self) -> int: ...


Row = TypeVar("Row", bound=StampedScan)


class Step(NamedTuple):
    """A clock that was set back."""

    after: int
    """Index of the first stamp after it."""
    seconds: float
    """Step from the last stamp before it, seconds."""


class Mended(NamedTuple):
    """Stamps, seconds, strictly increasing, and the repairs made to them."""

    stamps: FloatArray
    garbled: Sequence[int]
    """Indices of the stamps that were interpolated between their neighbours."""
    steps: Sequence[Step]


class Clock(NamedTuple):
    """Clock of a log: if its stamps cannot be trusted, they are times of receipt plus ``offset`` seconds."""

    trusted: bool
    offset: float

    def times(self, stamps: FloatArray, received: FloatArray | None) -> tuple[FloatArray, list[int]]:
        """Return the times of messages on this clock, and the indices of those whose own stamps use another clock."""
        if received is None or not len(stamps):
            return stamps, []
        received = increasing(received).stamps
        foreign = np.abs(stamps - received - self.offset) > _LATE
        if self.trusted and not foreign.all():
            return stamps, []
        return np.where(foreign, received + self.offset, stamps), np.flatnonzero(foreign).tolist()


def drop_repeats(rows: Sequence[Row], statistics: ReadStatistics) -> list[Row]:
    """Drop rows that were written twice, with the stamp and readings of an earlier one."""
    if _mostly_equal(np.array([row.stamp for row in rows])):
        return list(rows)
    seen: dict[float, Row] = {}
    kept = []
    for row in rows:
        first = seen.setdefault(row.stamp, row)
        if first.fingerprint == row.fingerprint and first.line != row.line:
            statistics.skip("repeated", row.line, scan=False)
        else:
            kept.append(row)
    return kept


def scan_times(
    stamps: FloatArray, received: FloatArray | None, places: Sequence[int], statistics: ReadStatistics
) -> tuple[FloatArray, Clock]:
    """Return strictly increasing times of scans with these stamps, seconds, and their clock.

    All repairs are counted at their places. ``received`` are the times of receipt of the scans, if the log has them.
    """
    if received is not None and (len(received) < 2 or _mostly_equal(received)):
        received = None
    if received is not None and _mostly_equal(stamps):
        for place in places:
            statistics.mend("stamps that are zero or equal, times of receipt used", place)
        return increasing(received).stamps, Clock(trusted=False, offset=0.0)
    if _mostly_equal(stamps):
        for place in places:
            statistics.mend("stamps that are zero or equal, taken in the order of the file as 10 scans a second", place)
        return stamps[0] + _INTERVAL * np.arange(len(stamps)), Clock(True, 0.0)
    return _corrected_times(stamps, received, places, statistics)


def _corrected_times(
    stamps: FloatArray, received: FloatArray | None, places: Sequence[int], statistics: ReadStatistics
) -> tuple[FloatArray, Clock]:
    corrected = increasing(stamps)
    clock = _clock(stamps, received, trusted=not (corrected.garbled or corrected.steps))
    for index in corrected.garbled:
        statistics.mend("stamps that do not increase, set between their neighbours", places[index])
    for step in corrected.steps:
        statistics.mend("clock that was set back, corrected", places[step.after], f"{step.seconds:.3f} s")
    if clock.trusted or received is None:
        return corrected.stamps, clock
    return increasing(clock.times(stamps, received)[0]).stamps, clock


def _clock(stamps: FloatArray, received: FloatArray | None, trusted: bool) -> Clock:
    if received is None:
        return Clock(trusted=True, offset=0.0)
    return Clock(trusted, median_low((stamps - increasing(received).stamps).tolist()))


def _mostly_equal(stamps: FloatArray) -> bool:
    """Return True if more than half of the neighbouring stamps are equal."""
    return len(stamps) > 1 and 2 * int(np.count_nonzero(np.diff(stamps) == 0.0)) > len(stamps) - 1


def increasing(stamps: FloatArray) -> Mended:
    """Return the stamps, strictly increasing in the given order.

    A few stamps out of order are interpolated; after a step back, time continues after a usual interval.
    """
    if (np.diff(stamps) > 0.0).all():
        return Mended(stamps, (), ())
    interval = _usual_interval(stamps)
    times, steps, last, shift = np.full(len(stamps), np.nan), list[Step](), -np.inf, 0.0
    for run in _runs(stamps.tolist()):
        first = float(stamps[run[0]])
        if first > last:
            shift = 0.0
        elif first + shift <= last:
            steps.append(Step(run[0], first - float(stamps[run[0] - 1])))
            shift = last + interval - first
        times[run] = stamps[run] + shift
        last = float(times[run[-1]])
    garbled = np.flatnonzero(np.isnan(times)).tolist()
    return Mended(_filled(times, interval), garbled, steps)


def _usual_interval(stamps: FloatArray) -> float:
    ahead = np.diff(stamps)
    return float(np.median(ahead[ahead > 0.0])) if (ahead > 0.0).any() else _INTERVAL


def _runs(stamps: list[float]) -> list[list[int]]:
    """Split the stamps into runs that increase, each given by the indices of its stamps, in the given order.

    Single stamps out of order are in no run.
    """
    kept, runs = set(longest_increasing(stamps)), list[list[int]]()
    for is_kept, group in groupby(range(len(stamps)), key=kept.__contains__):
        indices = list(group)
        if is_kept:
            runs.append(indices)
        elif len(indices) >= _RUN:
            own = longest_increasing([stamps[index] for index in indices])
            runs += [[indices[k] for k in own]] if len(own) >= max(_RUN, len(indices) // 2) else []
    return runs


def _filled(times: FloatArray, interval: float) -> FloatArray:
    """Replace each nan by a time between its neighbours, or an interval beyond the last."""
    known = np.flatnonzero(~np.isnan(times))
    index = np.arange(len(times))
    filled = np.interp(index, known, times[known])
    first, last = known[0], known[-1]
    filled[:first] -= interval * (first - index[:first])
    filled[last + 1 :] += interval * (index[last + 1 :] - last)
    return filled


def longest_increasing(values: Sequence[float]) -> list[int]:
    """Return indices of a longest strictly increasing subsequence; of equal neighbours the first is kept.

    Patience sorting (Fredman 1975), n log n: ``ends[k]`` is the end of the run of k + 1 values with the smallest end.
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
