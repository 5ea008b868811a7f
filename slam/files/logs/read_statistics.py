"""Statistics of reading a log: usable, skipped and ignored lines; lines out of order among the skipped ones."""

from bisect import bisect_left
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, TypeVar

from slam.errors import LogError


@dataclass(slots=True)
class ReadStatistics:
    """Counts for the report of a log."""

    path: Path
    skipped: Counter[str] = field(default_factory=Counter)
    """Unusable lines, by what is wrong with them."""
    ignored: Counter[str] = field(default_factory=Counter)
    """Messages of other types, by name."""
    notes: list[str] = field(default_factory=list)
    """Further remarks for the user."""
    _first: int | None = None

    def skip(self, kind: str, line: int) -> None:
        """Count an unusable line; lines are numbered from 1."""
        self.skipped[kind] += 1
        self._first = line if self._first is None else min(self._first, line)

    def report(self, scans: int) -> str:
        """One line, such as '4791 scans, 3 lines skipped (2 truncated, 1 not a number; first at line 17)'."""
        return "; ".join([", ".join([_number(scans, "scan"), *self._skips()]), *self.notes])

    def no_scans(self, expected: str) -> LogError:
        """The error of a log that has none."""
        names = [f"{count} {name}" for name, count in self.ignored.most_common()]
        found = ", ".join([*names, *self._skips()]) or "nothing"
        return LogError("; ".join([f"{self.path}: no scan in this log: {found}", *self.notes, f"need {expected}"]))

    def _skips(self) -> list[str]:
        if not self.skipped:
            return []
        kinds = ", ".join(f"{count} {kind}" for kind, count in self.skipped.most_common())
        return [f"{_number(self.skipped.total(), 'line')} skipped ({kinds}; first at line {self._first})"]


def _number(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


class Stamped(Protocol):
    """A scan line: its number in the file and its time in seconds."""

    @property
    def line(self) -> int: ...
    @property
    def stamp(self) -> float: ...


Row = TypeVar("Row", bound=Stamped)


def drop_out_of_order(rows: Sequence[Row], statistics: ReadStatistics) -> list[Row]:
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
