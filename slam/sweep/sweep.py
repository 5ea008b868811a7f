"""A whole sweep: what is missing is run, and its rows are kept."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass

import yaml

from slam.console.terminal import Terminal
from slam.errors import StorageError
from slam.sweep.driver import Driver
from slam.sweep.executor import Executor
from slam.sweep.folder import Folder
from slam.sweep.lock import Lock
from slam.sweep.plan import Plan
from slam.sweep.pool import Pool
from slam.sweep.progress import SweepProgress
from slam.sweep.store import SweepStore

RUNS = "runs"
"""The folder of the runs' folders."""
CONFIG = "sweep.yaml"
"""What was asked for last; ``hopslam sweep`` takes it."""


@dataclass(frozen=True, slots=True)
class SweepOptions:
    """What a sweep is run with."""

    jobs: int
    """Runs at a time; on a cluster that is there already, as many as it has processors."""
    ray: str | None = None
    """Address of the cluster; None: processes of this machine."""
    retry: int = 2
    """So often a run that failed is tried again."""
    pictures: bool = False
    """Of every run."""


@dataclass(frozen=True, slots=True)
class SweepOutcome:
    """What came of a sweep."""

    done: int
    """Runs that are over now, and were not before ..."""
    failed: int
    """... and those of them without a result."""
    before: int
    """Runs that were over already."""
    interrupted: bool


def run_sweep(plan: Plan, out: str, means: SweepOptions, console: Terminal) -> SweepOutcome:
    """Run the jobs that have no row under ``out``, a path or URL, or one that failed.

    InputError for settings that are wrong, before anything is run, and while another driver works there; StorageError
    where rows cannot be kept any more.
    """
    folder = Folder(out)
    with console.waiting("checking the settings"):
        plan.check()
    try:
        return _run_in(folder, plan, means, console)
    except OSError as error:
        raise StorageError(f"{out}: {error.strerror or error}; the rows that are there are kept") from error


def _run_in(folder: Folder, plan: Plan, means: SweepOptions, console: Terminal) -> SweepOutcome:
    with Lock(folder):
        store = SweepStore(folder)
        store.compact()
        for place in (folder, folder / RUNS):
            place.clear_drafts()
        folder.write(CONFIG, yaml.safe_dump(_whole(plan), sort_keys=False, allow_unicode=True))
        over = store.done()
        todo = sum(job.id not in over for job in plan.jobs())
        if not todo:
            return SweepOutcome(0, 0, len(plan), interrupted=False)
        executor = _executor(plan, folder, means, todo)
        with closing(executor), SweepProgress(console, plan.config.name, todo) as progress:
            driver = Driver(executor, store, means.retry, progress.show)
            interrupted = driver.run(job for job in plan.jobs() if job.id not in over)
    return SweepOutcome(driver.done, driver.failed, len(plan) - todo, interrupted)


def _executor(plan: Plan, folder: Folder, means: SweepOptions, todo: int) -> Executor:
    runs, pictures = (folder / RUNS).address, means.pictures
    if means.ray is None:
        return Pool(max(min(means.jobs, todo), 1), runs, pictures, plan.allowed)
    from slam.sweep.ray_cluster import RayCluster

    return RayCluster(means.ray, means.jobs, runs, pictures, plan.files(), plan.allowed)


def _whole(plan: Plan) -> dict[str, object]:
    """The configuration, with paths that are good from everywhere."""
    scenarios = [subject.source for subject in plan.subjects if subject.kind == "scenario"]
    logs = [subject.source for subject in plan.subjects if subject.kind == "log"]
    data = plan.config.model_dump(mode="json", exclude_defaults=True) | {"scenarios": scenarios, "logs": logs}
    return data | {"seeds": _shown(plan.config.seeds)}


def _shown(seeds: tuple[int, ...]) -> str | list[int]:
    """As short as it can be written."""
    end = seeds[0] + len(seeds)
    return f"{seeds[0]}:{end}" if seeds == tuple(range(seeds[0], end)) else list(seeds)
