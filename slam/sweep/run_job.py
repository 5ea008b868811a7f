"""The work of a sweep's worker: one run, with a row for every outcome."""

import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter
from typing import Final

import numpy as np

from slam.errors import HopslamError
from slam.pose import path_lengths
from slam.run.experiment import Experiment
from slam.run.experiment_setup import replay_experiment, scenario_experiment
from slam.run.results.traces import Traces, pose_errors
from slam.scenario.file import checked_template
from slam.sweep.code_bundle import bundled_path, versions
from slam.sweep.folder import Folder
from slam.sweep.job import Job
from slam.sweep.result_rows import Row, done_row, failed_row

CURVE_POINTS: Final = 64
"""Number of positions along the path, evenly from start to end, for short and long runs alike."""


def run_job(job: Job, runs: str, pictures: bool, allowed: Sequence[str] = ()) -> Row | None:
    """Run the job, and keep its folder as ``<id>`` under the address ``runs``; None if it was interrupted.

    A failed run has a row with its error: only an interruption leaves here. ``allowed`` is the code that the user
    allows; a job does not contain that permission.
    """
    began, started = perf_counter(), datetime.now(UTC)
    try:
        row = _run(job, runs, pictures, allowed)
    except HopslamError as error:
        row = failed_row(job, str(error))
    except Exception as error:  # noqa: BLE001  # whatever it is, the other runs go on
        row = failed_row(job, f"{type(error).__name__}: {error}")
    if row is None:
        return None
    seconds = round(perf_counter() - began, 4)
    where = {"host": platform.node(), "started": started.isoformat(timespec="seconds"), "seconds": seconds}
    return row | where | {"version": versions()["hopslam"]}


def make_experiment(job: Job, allowed: Sequence[str] = ()) -> Experiment:
    """Make the experiment of ``job.command``, with the code that the user allows."""
    settings, source = [*job.settings, f"seed={job.seed}"], bundled_path(job.source)
    if job.kind == "log":
        experiment = replay_experiment(Path(source), checked_template("replay", settings, allowed).draw())
        if experiment.loss is not None:
            experiment.loss.require_most(lenient=False, remedy="leave it out of the sweep")
        return experiment
    return scenario_experiment(checked_template(source, settings, allowed).draw())


def error_curve(folder: Path) -> list[float] | None:
    """Return the distance between estimate and true pose at CURVE_POINTS positions along the path; None if unknown."""
    traces = Traces.read(folder)
    if traces is None or traces.truth is None:
        return None
    errors = np.hypot(*pose_errors(traces.estimate, traces.truth)[:, :2].T)
    distances = path_lengths(traces.truth)
    at = np.linspace(0.0, distances[-1], CURVE_POINTS)
    return [round(value, 6) for value in np.interp(at, distances, errors).tolist()]


def _run(job: Job, runs: str, pictures: bool, allowed: Sequence[str]) -> Row | None:
    folder = Folder(runs)
    with folder.draft() as draft:
        outcome = make_experiment(job, allowed).run(draft / job.id, pictures=pictures)
        if outcome.ending == "interrupted":
            return None
        row = done_row(job, outcome) | {"error_m": error_curve(outcome.folder)}
        folder.move_in(outcome.folder, job.id)
    return row
