"""Sweeps for a command or a program: planned, run, and returned as values."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from slam.console.terminal import Terminal
from slam.scenario.settings import one_or_several, parse_setting
from slam.sweep.folder import Folder
from slam.sweep.make_plan import make_plan, parse_sample
from slam.sweep.plan import Plan
from slam.sweep.report.groups import group_runs, pick_metric
from slam.sweep.report.tables import tables
from slam.sweep.result_rows import Row
from slam.sweep.result_store import ResultStore
from slam.sweep.sweep import ExecutionOptions, SweepOutcome, run_sweep
from slam.system import usable_cores

if TYPE_CHECKING:
    from slam.sweep.report.write import SweepReport


@dataclass(frozen=True, slots=True)
class Sweep:
    """The results of a sweep, and the number of runs made now."""

    folder: str
    """Path or URL."""
    done: int = 0
    """Number of runs finished now."""
    failed: int = 0
    """Number of runs finished now without a result."""
    before: int = 0
    """Number of runs that had been finished before."""
    interrupted: bool = False

    @classmethod
    def of(cls, folder: str, outcome: SweepOutcome) -> Self:
        """Make the sweep in this folder, with this outcome."""
        return cls(folder, outcome.done, outcome.failed, outcome.before, outcome.interrupted)

    def rows(self, columns: Sequence[str] | None = None) -> list[Row]:
        """Return a dictionary for each run: ``mode``, ``seed``, ``set.<key>``, ``status``, and every metric.

        ``columns`` selects some of them; docs/sweeps.md lists them. ``pandas.DataFrame`` accepts the result.
        """
        return list(self._store().rows(None if columns is None else list(columns)))

    def report(self, metric: str | None = None) -> SweepReport:
        """Write tables, comparisons and pictures into the folder ``report``; ``page`` is the path of the HTML page."""
        from slam.sweep.report.write import write_report  # imported here, as matplotlib loads slowly

        return write_report(self.folder, metric)

    def _store(self) -> ResultStore:
        store = ResultStore(Folder(self.folder))
        store.compact()
        return store

    def _repr_html_(self) -> str:
        """The tables of the report."""
        store = self._store()
        metric = pick_metric(store, None)
        return "".join(table.html() for table in tables(group_runs(store, metric), metric))


def sweep(
    scenarios: str | Sequence[str],
    *,
    seeds: str | int | Iterable[int] | None = None,
    modes: str | Sequence[str] = (),
    grid: Mapping[str, Iterable[Any]] | None = None,
    sample: Mapping[str, Any] | None = None,
    settings: str | Sequence[str] = (),
    jobs: int | None = None,
    ray: str | None = None,
    out: str | os.PathLike[str] | None = None,
    retry: int = 2,
    pictures: bool = False,
    allow_modules: str | Sequence[str] = (),
    check: bool = True,
    console: Terminal | None = None,
) -> Sweep:
    """Run scenarios and logs by mode, settings and seed, as ``hopslam sweep`` does; runs with a result are skipped.

    ``seeds`` are ``"first:end"``, without the end, or numbers; ``grid`` has the values of each setting that are tried,
    and ``sample`` a distribution for each setting that is drawn by seed, such as ``"uniform(0.1, 0.2)"``. Runs use
    ``jobs`` processes, by default one for each processor, or a cluster at ``ray``; results are written to ``out``, a
    path or URL, by default ``sweeps/<name>``. InputError for wrong arguments, before any run. A failed run has a row
    with its error. An interrupted sweep raises KeyboardInterrupt; with ``check=False`` it is returned instead.
    """
    planned = plan(scenarios, seeds, modes, grid, sample, settings, allow_modules)
    address = folder_of(planned, out)
    options = ExecutionOptions(jobs or usable_cores(), ray, retry, pictures)
    outcome = run_sweep(planned, address, options, console or Terminal(quiet=True))
    if check and outcome.interrupted:
        raise KeyboardInterrupt(f"run the same sweep again to add the missing runs to {address}")
    return Sweep.of(address, outcome)


def plan(
    scenarios: str | Sequence[str],
    seeds: str | int | Iterable[int] | None = None,
    modes: str | Sequence[str] = (),
    grid: Mapping[str, Iterable[Any]] | None = None,
    sample: Mapping[str, Any] | None = None,
    settings: str | Sequence[str] = (),
    allow_modules: str | Sequence[str] = (),
) -> Plan:
    """Return the runs of a sweep; see ``sweep``."""
    given = {
        "seeds": seeds if seeds is None or isinstance(seeds, str | int) else [_plain(seed) for seed in seeds],
        "modes": one_or_several(modes),
        "grid": {key: [_plain(value) for value in values] for key, values in (grid or {}).items()},
        "sample": dict(_sampled(*item) for item in (sample or {}).items()),
        "settings": {".".join(map(str, key)): value for key, value in map(parse_setting, one_or_several(settings))},
    }
    changes = {key: value for key, value in given.items() if value not in (None, (), {})}
    return make_plan(scenarios, changes, allow_modules)


def folder_of(planned: Plan, out: str | os.PathLike[str] | None) -> str:
    """Return path or URL of the results."""
    return f"sweeps/{planned.config.name}" if out is None else os.fspath(out)


def _sampled(key: str, distribution: Any) -> tuple[str, Any]:
    """Return a setting and its distribution, given as a mapping or in the form of the command line."""
    return parse_sample(f"{key}={distribution}") if isinstance(distribution, str) else (key, distribution)


def _plain(value: Any) -> Any:
    """Convert a number of numpy to one of Python."""
    return value.item() if hasattr(value, "item") else value
