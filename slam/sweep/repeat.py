"""Runs one row of a sweep again, and compares the results."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Final

from slam.errors import InputError, ScenarioError
from slam.scenario.file import checked_template
from slam.sweep.executor import FinishedJob
from slam.sweep.folder import Folder
from slam.sweep.job import Job
from slam.sweep.process_pool import ProcessPool
from slam.sweep.result_rows import Row, repeatable_columns
from slam.sweep.result_store import ResultStore
from slam.sweep.sweep_input import SweepInput

_REPEATED: Final = "repeated"
"""Folder of the repeated runs."""


@dataclass(frozen=True, slots=True)
class Repetition:
    """Comparison of a run with its repetition."""

    command: str
    """Shell command of the same run."""
    folder: str
    differences: list[str]
    """Names of the columns with different bits."""
    compared: int
    """Number of columns."""


def repeat_run(out: str, run_id: str, pictures: bool = False, allow_modules: Sequence[str] = ()) -> Repetition:
    """Run the row with that id, or the only one that begins with it, again in a new process.

    InputError if there is no such row, its scenario or log has changed, or it names code whose module is not in
    ``allow_modules``.
    """
    folder = Folder(out)
    row = _find(ResultStore(folder), run_id, out)
    job = _job_of(row)
    try:
        checked_template(job.source if job.kind == "scenario" else "replay", job.settings, allow_modules)
    except ScenarioError as error:
        raise InputError(f"{out}: run {job.id}: {error}") from error
    with closing(ProcessPool(1, (folder / _REPEATED).address, pictures, allow_modules)) as pool:
        pool.submit(job)
        result = next(iter(pool.collect(timeout=1e6)))
    again = result.row if isinstance(result, FinishedJob) else {"status": "failed", "error": result.reason}
    before, after = repeatable_columns(row), repeatable_columns(again)
    differences = [name for name in before if before[name] != after.get(name)]
    return Repetition(job.command, (folder / _REPEATED / job.id).address, differences, len(before))


def _find(store: ResultStore, run_id: str, out: str) -> Row:
    store.compact()
    found = [row for row in store.rows() if row["id"].startswith(run_id)]
    if len(found) != 1:
        raise InputError(f"{out}: {len(found)} rows have an id that begins with {run_id!r}; give more of it")
    return found[0]


def _job_of(row: Row) -> Job:
    read = SweepInput.from_scenario if row["kind"] == "scenario" else SweepInput.from_log
    job = Job.create(
        read(row["source"]).digest,
        **{key: row[key] for key in ("kind", "name", "source", "mode", "seed")},
        settings=tuple(row["settings"]),
    )
    if job.id != row["id"]:
        raise InputError(f"{row['source']} has changed since {row['id']} was run, which therefore cannot be repeated")
    return job
