"""The tables of ``hopslam bench sweep``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from rich.console import Console

from slam.run.bench.sweep_runs import SweepSpeed, memory_of_rows, sweep_speed
from slam.run.bench.tables import ResultTable
from slam.run.bench.two_processes import arithmetic_ratio
from slam.run.results.keep import Keep
from slam.run.sweep.executor import Executor
from slam.run.sweep.pool import Pool


def sweep_tables(runs: int, ray: bool, console: Console) -> Iterator[ResultTable]:
    """Speed with one and with two jobs, beside what the machine allows; memory of the driver."""
    with console.status("one process and two"):
        allowed = arithmetic_ratio()
    rows = []
    for name, make in _executors(ray).items():
        with console.status(f"{runs} runs, {name}"):
            one, two = (sweep_speed(make, jobs, runs) for jobs in (1, 2))
        rows += [_row(name, 1, one, one), _row("", 2, two, one)]
    columns = ("executor", "jobs", "runs/s", "x one", "driver\n% of a core", "overhead\ns a run")
    notes = (
        f"{runs} warm runs of paper_simulation, this project's method. Additions alone, in two processes of this "
        f"machine: {allowed:.2f} x one, just before. Overhead: a worker's time less that in which the robot drives."
    )
    yield ResultTable("Sweeps, one job and two at a time", columns, rows, notes)
    with console.status("10,000 rows"):
        few, many = memory_of_rows(100), memory_of_rows(10_000)
    held = [("100", f"{few:.1f}"), ("10,000", f"{many:.1f}")]
    yield ResultTable("Memory of the driver", ("rows", "MB"), held, "Of simulated runs, after the last one.")


def _executors(ray: bool) -> Mapping[str, Callable[[str, int], Executor]]:
    return {"pool": _pool} | ({"Ray": _ray} if ray else {})


def _pool(runs: str, jobs: int) -> Executor:
    return Pool(jobs, runs, Keep(pictures=False))


def _ray(runs: str, jobs: int) -> Executor:
    from slam.run.sweep.ray_cluster import LOCAL, RayCluster

    return RayCluster(LOCAL, jobs, runs, Keep(pictures=False))


def _row(name: str, jobs: int, speed: SweepSpeed, one: SweepSpeed) -> tuple[str, ...]:
    share = f"{100 * speed.driver:.1f}"
    return name, str(jobs), f"{speed.rate:.2f}", f"{speed.rate / one.rate:.2f}", share, f"{speed.overhead:.3f}"
