"""What a sweep would run, and how long that takes."""

from __future__ import annotations

from math import ceil
from statistics import median

from slam.console.result_table import ResultTable
from slam.sweep.estimate import seconds_of
from slam.sweep.folder import Folder
from slam.sweep.plan import Case, Plan
from slam.sweep.store import SweepStore


def plan_table(plan: Plan, out: str, jobs: int) -> ResultTable:
    """A row a case: its runs, those that are over, seconds of one; and the time of what is left, ``jobs`` at a time.

    Seconds are those of the runs that are over, and where none is, of a first look. ScenarioError for wrong settings.
    """
    plan.check()
    over = _seconds_by_id(SweepStore(Folder(out)))
    rows, left, runs_left = [], 0.0, 0
    for case in plan.cases:
        known = [over[job] for job in _ids(plan, case) if job in over]
        seconds = median(known) if known else seconds_of(plan.job(case, plan.config.seeds[0]), plan.allowed)
        todo = len(plan.config.seeds) - len(known)
        left, runs_left = left + todo * seconds, runs_left + todo
        rows.append([case.label, str(len(plan.config.seeds)), str(len(known)), f"{seconds:.1f}"])
    notes = (
        f"{len(plan)} runs, {runs_left} of them to do: about {_duration(left / jobs)} with {jobs} at a time; in {out}"
    )
    return ResultTable(f"Plan of {plan.config.name}", ("case", "runs", "done", "s a run"), rows, notes)


def _ids(plan: Plan, case: Case) -> list[str]:
    return [plan.job(case, seed).id for seed in plan.config.seeds]


def _seconds_by_id(store: SweepStore) -> dict[str, float]:
    rows = store.rows(["id", "status", "seconds"])
    return {row["id"]: row["seconds"] for row in rows if row["status"] == "done"}


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{ceil(seconds)} s"
    return f"{ceil(seconds / 60)} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
