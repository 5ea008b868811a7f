"""What a worker does: one run, whatever becomes of it."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter

from slam.errors import HopslamError
from slam.run.experiment import Experiment
from slam.run.experiment_setup import replay_experiment, scenario_experiment
from slam.scenario.file import checked_template
from slam.sweep.bundled_file import shipped_file
from slam.sweep.error_curve import error_curve
from slam.sweep.folder import Folder
from slam.sweep.job import Job
from slam.sweep.row import Row, done, failed
from slam.sweep.versions import versions


def run_job(job: Job, runs: str, pictures: bool, allowed: Sequence[str] = ()) -> Row | None:
    """Run it, and keep its folder as ``<id>`` under the address ``runs``; None when it was interrupted.

    A run that fails has a row that says so: only an interruption leaves here. ``allowed`` is the code that the user
    allows; a job says only what it names.
    """
    began, started = perf_counter(), datetime.now(UTC)
    try:
        row = _run(job, runs, pictures, allowed)
    except HopslamError as error:
        row = failed(job, str(error))
    except Exception as error:  # whatever it is, the other runs go on
        row = failed(job, f"{type(error).__name__}: {error}")
    if row is None:
        return None
    seconds = round(perf_counter() - began, 4)
    where = {"host": platform.node(), "started": started.isoformat(timespec="seconds"), "seconds": seconds}
    return row | where | {"version": versions()["hopslam"]}


def experiment_of(job: Job, allowed: Sequence[str] = ()) -> Experiment:
    """The experiment that ``job.command`` runs, with the code that the user allows."""
    settings, source = [*job.settings, f"seed={job.seed}"], shipped_file(job.source)
    if job.kind == "log":
        return replay_experiment(Path(source), checked_template("replay", settings, allowed).draw())
    return scenario_experiment(checked_template(source, settings, allowed).draw())


def _run(job: Job, runs: str, pictures: bool, allowed: Sequence[str]) -> Row | None:
    folder = Folder(runs)
    with folder.draft() as draft:
        outcome = experiment_of(job, allowed).run(draft / job.id, pictures=pictures)
        if outcome.ending == "interrupted":
            return None
        row = done(job, outcome) | {"error_m": error_curve(outcome.folder)}
        folder.take_in(outcome.folder, job.id)
    return row
