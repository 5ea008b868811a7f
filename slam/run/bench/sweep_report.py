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
            one, two = _alternating(make, runs)
        rows += [_row(name, 1, one, one), _row("", 2, two, one)]
    columns = ("executor", "jobs", "runs/s", "x one", "driver\n% of a core", "overhead\ns a run")
    notes = (
        f"{runs} warm runs of paper_simulation, this project's method; the better of two turns. Additions alone, in "
        f"two processes of this machine: {allowed:.2f} x one, just before. Overhead: a worker's time less that in "
        f"which the robot drives."
    )
    yield ResultTable("Sweeps, one job and two at a time", columns, rows, notes)
    with console.status("10,000 rows"):
        held = [(f"{count:,}", f"{memory_of_rows(count):.0f}") for count in (100, 1000, 10_000)]
    yield ResultTable("Memory of the driver", ("rows", "MB"), held, "Of simulated runs, after the last one.")


def _alternating(make: Callable[[str, int], Executor], runs: int) -> tuple[SweepSpeed, SweepSpeed]:
    """With one job and with two, the faster of two turns each: others may load the machine meanwhile."""
    turns = [(sweep_speed(make, 1, runs), sweep_speed(make, 2, runs)) for _ in range(2)]
    one, two = (max(speeds, key=lambda speed: speed.rate) for speeds in zip(*turns, strict=True))
    return one, two


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
