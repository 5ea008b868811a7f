"""Statistics of reading a log: usable, skipped and ignored lines."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

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
