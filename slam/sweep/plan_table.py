"""Table of the planned runs of a sweep and their time, before it starts."""

from collections.abc import Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from math import ceil
from statistics import median
from time import perf_counter
from typing import Final

from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.run.loop import run_loop
from slam.run.step import Step
from slam.run.warm_up import warm_up
from slam.sweep.folder import Folder
from slam.sweep.job import Job
from slam.sweep.plan import Plan
from slam.sweep.result_store import ResultStore
from slam.sweep.run_job import make_experiment

_TRIAL_TIME: Final = 2.0
"""Seconds for which a run is timed."""


def plan_table(plan: Plan, out: str, jobs: int) -> ResultTable:
    """Make a row for each case: its runs, the finished ones, seconds per run; then the remaining time.

    Seconds are those of the finished runs; without any, a short run measures them. ScenarioError for wrong settings.
    """
    plan.check()
    found = ResultStore(Folder(out)).rows(["id", "status", "seconds"])
    over = {row["id"]: row["seconds"] for row in found if row["status"] == "done"}
    seeds, rows, left, runs_left = plan.config.seeds, [], 0.0, 0
    for case in plan.cases:
        known = [over[id_] for seed in seeds if (id_ := plan.job(case, seed).id) in over]
        seconds = median(known) if known else estimate_seconds(plan.job(case, seeds[0]), plan.allowed)
        todo = len(seeds) - len(known)
        left, runs_left = left + todo * seconds, runs_left + todo
        rows.append([case.label, str(len(seeds)), str(len(known)), f"{seconds:.1f}"])
    time_left = _duration(left / jobs)
    notes = f"{len(plan)} runs, {runs_left} of them to do: about {time_left} with {jobs} at a time; in {out}"
    return ResultTable(f"Plan of {plan.config.name}", ("case", "runs", "done", "s a run"), rows, notes)


def estimate_seconds(job: Job, allowed: Sequence[str]) -> float:
    """Estimate how long this job takes from its first two seconds; InputError where it cannot be run at all."""
    experiment = make_experiment(job, allowed)
    experiment.env.prepare(job.seed)
    warm_up(Terminal(quiet=True), experiment.scenario.slam)
    trial = _Trial(perf_counter())
    with closing(experiment.env), suppress(KeyboardInterrupt):
        run_loop(experiment.env, experiment.slam, experiment.pilot, [trial], experiment.seed)
    taken = perf_counter() - trial.began
    return taken / trial.progress if 0.0 < trial.progress < 1.0 else taken


@dataclass
class _Trial:
    """Watcher that ends a run after _TRIAL_TIME."""

    began: float
    progress: float = 0.0
    """Share of the run that is over."""

    def on_step(self, step: Step) -> None:
        self.progress = step.progress
        if perf_counter() - self.began > _TRIAL_TIME:
            raise KeyboardInterrupt


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{ceil(seconds)} s"
    return f"{ceil(seconds / 60)} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
