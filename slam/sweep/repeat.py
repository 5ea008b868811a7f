"""One row of a sweep, run again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from slam.errors import InputError, ScenarioError
from slam.scenario.file import checked_template
from slam.sweep.executor import Finished
from slam.sweep.folder import Folder
from slam.sweep.job import Job
from slam.sweep.pool import Pool
from slam.sweep.row import Row, comparable
from slam.sweep.store import SweepStore
from slam.sweep.sweep_input import SweepInput

REPEATED = "repeated"
"""The folder of the runs' folders."""


@dataclass(frozen=True, slots=True)
class Repeated:
    """What came of it."""

    command: str
    """The same run by hand."""
    folder: str
    differences: list[str]
    """Columns that are not the same bits."""
    compared: int
    """Columns."""


def repeated(out: str, run_id: str, pictures: bool = False, allow_modules: Sequence[str] = ()) -> Repeated:
    """Run the row of that id, or of the only one that begins so, in a process of its own.

    InputError where there is no such row, its scenario or log has changed since, or it names code whose module is not
    in ``allow_modules``.
    """
    folder = Folder(out)
    row = _find(SweepStore(folder), run_id, out)
    job = _job_of(row)
    try:
        checked_template(job.source if job.kind == "scenario" else "replay", job.settings, allow_modules)
    except ScenarioError as error:
        raise InputError(f"{out}: run {job.id}: {error}") from error
    pool = Pool(1, (folder / REPEATED).address, pictures, allow_modules)
    try:
        pool.submit(job)
        came = next(iter(pool.collect(timeout=1e6)))
    finally:
        pool.close()
    again = came.row if isinstance(came, Finished) else {"status": "failed", "error": came.reason}
    before, after = comparable(row), comparable(again)
    differences = [name for name in before if before[name] != after.get(name)]
    return Repeated(job.command, (folder / REPEATED / job.id).address, differences, len(before))


def _find(store: SweepStore, run_id: str, out: str) -> Row:
    store.compact()
    found = [row for row in store.rows() if row["id"].startswith(run_id)]
    if len(found) != 1:
        raise InputError(f"{out}: {len(found)} rows have an id that begins with {run_id!r}; give more of it")
    return found[0]


def _job_of(row: Row) -> Job:
    of = SweepInput.of_scenario if row["kind"] == "scenario" else SweepInput.of_log
    job = Job.of(
        of(row["source"]).digest,
        **{key: row[key] for key in ("kind", "name", "source", "mode", "seed")},
        settings=tuple(row["settings"]),
    )
    if job.id != row["id"]:
        raise InputError(f"{row['source']} is not what it was when {row['id']} was run; no run can be the same")
    return job
