"""A whole sweep: run the missing jobs, and store their rows."""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from time import perf_counter
from typing import Final

import yaml

from slam.console.terminal import Terminal
from slam.errors import StorageError
from slam.sweep.executor import Executor
from slam.sweep.folder import Folder
from slam.sweep.lock import SweepLock
from slam.sweep.plan import Plan
from slam.sweep.process_pool import ProcessPool
from slam.sweep.result_store import ResultStore
from slam.sweep.scheduler import Scheduler

RUNS: Final = "runs"
"""Folder of the runs' folders."""
CONFIG: Final = "sweep.yaml"
"""Configuration of the last sweep in the folder; ``hopslam sweep`` accepts it."""


@dataclass(frozen=True, slots=True)
class ExecutionOptions:
    """Options for the execution of a sweep's runs."""

    jobs: int
    """Runs at a time; an existing cluster runs as many as it has processors."""
    ray: str | None = None
    """Address of the cluster; None for processes of this machine."""
    retry: int = 2
    """Number of times that a failed run is repeated."""
    pictures: bool = False
    """Draw map and errors of every run."""


@dataclass(frozen=True, slots=True)
class SweepOutcome:
    """Numbers of runs of a sweep."""

    done: int
    """Runs finished now."""
    failed: int
    """Runs finished now without a result."""
    before: int
    """Runs that had been finished before."""
    interrupted: bool


def run_sweep(plan: Plan, out: str, options: ExecutionOptions, console: Terminal) -> SweepOutcome:
    """Run the jobs without a row under ``out``, a path or URL, and those that failed.

    InputError for wrong settings, before any run, and while another driver works there; StorageError if rows cannot be
    written.
    """
    folder = Folder(out)
    with console.waiting("checking the settings"):
        plan.check()
    try:
        return _run_in(folder, plan, options, console)
    except OSError as error:
        raise StorageError(f"{out}: {error.strerror or error}; the rows that are there are kept") from error


def _run_in(folder: Folder, plan: Plan, options: ExecutionOptions, console: Terminal) -> SweepOutcome:
    with SweepLock(folder):
        store = ResultStore(folder)
        for damage in store.set_damaged_aside():
            console.print(f"warning: {damage}")
        store.compact()
        folder.clear_drafts()
        (folder / RUNS).clear_drafts()
        folder.write(CONFIG, yaml.safe_dump(_absolute_config(plan), sort_keys=False, allow_unicode=True))
        over = store.done()
        todo = sum(job.id not in over for job in plan.jobs())
        if not todo:
            return SweepOutcome(0, 0, len(plan), interrupted=False)
        executor = _executor(plan, folder, options, todo)
        with closing(executor), _progress(console, plan.config.name, todo) as show:
            scheduler = Scheduler(executor, store, options.retry, show)
            interrupted = scheduler.run(job for job in plan.jobs() if job.id not in over)
        (folder / RUNS).clear_drafts()  # killed workers leave them
    return SweepOutcome(scheduler.done, scheduler.failed, len(plan) - todo, interrupted)


@contextmanager
def _progress(console: Terminal, name: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar; yield the function that shows how many runs are finished, and how many have no result."""
    columns = "{task.completed}/{task.total} runs", "{task.fields[failed]} failed", "{task.fields[rate]}"
    began = perf_counter()
    with console.progress(*columns) as bar:
        task = bar.add_task(name, total=total, failed=0, rate="")

        def show(done: int, failed: int) -> None:
            rate = f"{done / max(perf_counter() - began, 1e-9):.2f} runs/s"
            bar.update(task, completed=done, failed=failed, rate=rate)

        yield show


def _executor(plan: Plan, folder: Folder, options: ExecutionOptions, todo: int) -> Executor:
    runs, pictures = (folder / RUNS).address, options.pictures
    if options.ray is None:
        return ProcessPool(max(min(options.jobs, todo), 1), runs, pictures, plan.allowed)
    from slam.sweep.ray_cluster import RayCluster

    return RayCluster(options.ray, options.jobs, runs, pictures, plan.files(), plan.allowed)


def _absolute_config(plan: Plan) -> dict[str, object]:
    """Return the configuration with absolute paths, and with seeds as ``first:end`` if they are a range."""
    scenarios = [input_.source for input_ in plan.inputs if input_.kind == "scenario"]
    logs = [input_.source for input_ in plan.inputs if input_.kind == "log"]
    seeds = plan.config.seeds
    end = seeds[0] + len(seeds)
    is_range = seeds == tuple(range(seeds[0], end))
    changes = {"scenarios": scenarios, "logs": logs, "seeds": f"{seeds[0]}:{end}" if is_range else list(seeds)}
    return plan.config.model_dump(mode="json", exclude_defaults=True) | changes
