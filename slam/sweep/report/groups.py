"""The rows of a sweep, grouped by case: name, mode and the settings of the grid."""

from dataclasses import dataclass, field
from typing import Any, Final

from slam.errors import InputError, did_you_mean
from slam.modes import MODES
from slam.sweep.result_rows import Row
from slam.sweep.result_store import ResultStore

_DEFAULT_METRICS: Final = ("ate_rmse_m", "wall.slam_ms_median")
"""Default metric: the first of these with a value."""


@dataclass(eq=False)
class RunGroup:
    """Runs of one case: the successful ones, and failures."""

    name: str
    mode: str
    grid: dict[str, Any]
    seeds: list[int] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    """Metric of each run."""
    curves: list[tuple[float, list[float]]] = field(default_factory=list)
    """Distance driven, metres, and error along the path, of the runs for which it is known."""
    drawn: list[dict[str, float]] = field(default_factory=list)
    """Drawn settings of each run."""
    commands: list[tuple[str, str]] = field(default_factory=list)
    """Id and command of each run."""
    failures: list[tuple[str, str, str]] = field(default_factory=list)
    """Id, error and command of the runs without a result."""
    collided: int = 0
    runs: int = 0

    @property
    def label(self) -> str:
        """Name within its scenario."""
        return ", ".join([self.mode, *(f"{key.rpartition('.')[2]}={value}" for key, value in self.grid.items())])

    def add(self, row: Row, metric: str) -> None:
        """Add a run by its row."""
        self.runs += 1
        if row["status"] != "done":
            self.failures.append((row["id"], row["error"] or "", row["command"]))
            return
        self.collided += row["ending"] == "collided"
        if row.get(metric) is None:
            return
        self.seeds.append(row["seed"])
        self.values.append(float(row[metric]))
        self.commands.append((row["id"], row["command"]))
        self.drawn.append(_prefixed(row, "drawn."))
        if row.get("error_m"):
            self.curves.append((row["path_m"], row["error_m"]))


def pick_metric(store: ResultStore, asked: str | None) -> str:
    """Choose the reported column; InputError if it has no numbers."""
    numbers = {
        key: None
        for row in store.rows()
        for key, value in row.items()
        if isinstance(value, int | float) and not key.startswith(("set.", "drawn."))
    }
    found = next((name for name in ([asked] if asked else _DEFAULT_METRICS) if name in numbers), None)
    if found is None:
        reason = f"no column {asked!r} of numbers; {did_you_mean(asked, list(numbers))}" if asked else ""
        raise InputError(reason or "no run has a result yet")
    return found


def group_runs(store: ResultStore, metric: str) -> list[RunGroup]:
    """Return cases in the order of name, mode and settings; each is compared with the first case of its name."""
    groups: dict[tuple[Any, ...], RunGroup] = {}
    for row in store.rows():
        grid = _prefixed(row, "set.")
        key = (row["name"], row["mode"], *grid.items())
        groups.setdefault(key, RunGroup(row["name"], row["mode"], grid)).add(row, metric)
    return sorted(groups.values(), key=_order)


def group_by_name(groups: list[RunGroup]) -> dict[str, list[RunGroup]]:
    """Return the cases of each scenario or log."""
    names = dict.fromkeys(group.name for group in groups)
    return {name: [group for group in groups if group.name == name] for name in names}


def _order(group: RunGroup) -> tuple[Any, ...]:
    place = [*MODES, group.mode].index(group.mode)
    return group.name, place, [(isinstance(value, str), value) for value in group.grid.values()]


def _prefixed(row: Row, prefix: str) -> dict[str, Any]:
    return {key.removeprefix(prefix): row[key] for key in row if key.startswith(prefix) and row[key] is not None}
