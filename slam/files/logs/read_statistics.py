"""Statistics of reading a log: what was read, skipped, and repaired, each with its place in the file."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from slam.errors import LogError
from slam.limits import SCANS


@dataclass(slots=True)
class Tally:
    """Occurrences of one kind of fault, in lines or messages of a file, which are numbered from 1."""

    count: int
    first: int
    last: int
    detail: str
    """Detail of the first one, such as a field and its value; may be empty."""

    def skipped(self, kind: str, unit: str) -> str:
        """Format count, kind, detail and interval, such as '1 impossible value: range_max nan, line 3'."""
        return f"{self.count} {self._with_detail(kind)}, {self._place(unit)}"

    def corrected(self, kind: str, unit: str) -> str:
        """Format a kind in the plural, such as 'stamps that do not increase (2: lines 3 to 9)'."""
        return f"{self._with_detail(kind)} ({self.count}: {self._place(unit)})"

    def _with_detail(self, kind: str) -> str:
        return f"{kind}: {self.detail}" if self.detail else kind

    def _place(self, unit: str) -> str:
        return f"{unit} {self.first}" if self.first == self.last else f"{unit}s {self.first} to {self.last}"


@dataclass(slots=True)
class ReadStatistics:
    """Counts for the report of a log."""

    path: Path
    unit: str = "line"
    """Unit of the file, line or message, in which places are counted."""
    ignored: Counter[str] = field(default_factory=Counter)
    """Messages of other types, by name."""
    notes: list[str] = field(default_factory=list)
    """Further remarks for the user."""
    lost: int = 0
    """Number of skipped scans."""
    _skips: dict[str, Tally] = field(default_factory=dict)
    _corrected: dict[str, Tally] = field(default_factory=dict)

    @property
    def skipped(self) -> Counter[str]:
        """Number of unusable lines, by their fault."""
        return Counter({kind: tally.count for kind, tally in self._skips.items()})

    def skip(self, kind: str, place: int, detail: str = "", scan: bool = True) -> None:
        """Count an unusable line or message; ``scan`` if it was a scan."""
        self.lost += scan
        _count(self._skips, kind, place, detail)

    def is_full(self, scans: int) -> bool:
        """Return True, and note it, if these are more scans than the limit for a log."""
        excess = SCANS.excess(scans)
        if excess:
            self.notes.append(f"it is read no further: {excess}")
        return excess is not None

    def mend(self, kind: str, place: int, detail: str = "") -> None:
        """Count a line that is used although something was wrong with it; ``kind`` says what, in the plural."""
        _count(self._corrected, kind, place, detail)

    def report(self, scans: int) -> str:
        """Format one line, such as '4791 scans, 3 lines skipped (2 truncated, lines 17 to 40)'."""
        corrected = [tally.corrected(kind, self.unit) for kind, tally in self._corrected.items()]
        return "; ".join([", ".join([_number(scans, "scan"), *self._skipped()]), *corrected, *self.notes])

    def no_scans(self, expected: str) -> LogError:
        """Make the error of a log without a scan."""
        names = [f"{count} {name}" for name, count in self.ignored.most_common()]
        found = ", ".join([*names, *self._skipped()]) or "no message of a robot"
        return LogError("; ".join([f"{self.path}: no scan in this log: {found}", *self.notes, f"need {expected}"]))

    def _skipped(self) -> list[str]:
        if not self._skips:
            return []
        often = sorted(self._skips.items(), key=lambda item: -item[1].count)
        kinds = "; ".join(tally.skipped(kind, self.unit) for kind, tally in often)
        return [f"{_number(sum(tally.count for _, tally in often), self.unit)} skipped ({kinds})"]


def _count(tallies: dict[str, Tally], kind: str, place: int, detail: str) -> None:
    tally = tallies.setdefault(kind, Tally(0, place, place, detail))
    tally.count += 1
    if place < tally.first:
        tally.first, tally.detail = place, detail
    tally.last = max(tally.last, place)


def _number(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
