"""``hopslam bench sweep``: speed and memory of sweeps."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple
from statistics import median
from typing import Final

from slam.bench.sweep_runs import SweepSpeed, arithmetic_ratio, memory_of_rows, sweep_speed
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.sweep.executor import Executor
from slam.sweep.process_pool import ProcessPool

TURNS: Final = 5
"""Number of rounds. As the load of a machine varies, ratios are taken within a round, and their median is shown."""


def sweep_tables(runs: int, ray: bool, console: Terminal) -> Iterator[ResultTable]:
    """Speed with one and with two jobs, beside what the machine allows; memory of the driver."""
    rows = []
    for name, make in _executors(ray).items():
        with console.progress() as bar:
            turns = bar.track(range(TURNS), description=f"{runs} runs, {name}")
            measured = [(arithmetic_ratio(), sweep_speed(make, 1, runs), sweep_speed(make, 2, runs)) for _ in turns]
            rows += _rows(name, measured)
    columns = ("executor", "jobs", "runs/s", "speed-up", "least, most", "driver\n% of a core", "overhead\ns a run")
    notes = (
        f"{runs} warm runs of paper_simulation, this project's method; medians of {TURNS} rounds. Additions alone: the "
        f"speed-up of plain additions in two processes of this machine, in the same rounds. Overhead: time of a worker "
        f"in which the robot does not drive."
    )
    yield ResultTable("Sweeps, one job and two at a time", columns, rows, notes)
    with console.waiting("10,000 rows"):
        held = [(f"{count:,}", f"{memory_of_rows(count):.0f}") for count in (100, 1000, 10_000)]
    notes = "Peak memory until this number of rows of simulated runs was stored."
    yield ResultTable("Memory of the driver", ("rows", "MB"), held, notes)


def _rows(name: str, turns: Sequence[tuple[float, SweepSpeed, SweepSpeed]]) -> list[tuple[str, ...]]:
    """One job, two jobs, and the additions."""
    additions, one, two = zip(*turns, strict=True)
    ones, twos = _speed(one), _speed(two)
    ratios = [b.rate / a.rate for a, b in zip(one, two, strict=True)]
    return [
        (name, "1", ones[0], "1.00", "", *ones[1:]),
        ("", "2", twos[0], *_ratio(ratios), *twos[1:]),
        ("additions alone", "2", "", *_ratio(additions), "", ""),
    ]


def _ratio(ratios: Sequence[float]) -> tuple[str, str]:
    return f"{median(ratios):.2f}", f"{min(ratios):.2f}, {max(ratios):.2f}"


def _speed(speeds: Sequence[SweepSpeed]) -> tuple[str, str, str]:
    """Medians of the runs per second, the driver's share in percent, and the overhead."""
    rate, driver, overhead = (median(values) for values in zip(*map(astuple, speeds), strict=True))
    return f"{rate:.2f}", f"{100 * driver:.1f}", f"{overhead:.3f}"


def _executors(ray: bool) -> Mapping[str, Callable[[str, int], Executor]]:
    """Functions that make an executor from the URL of the runs and a number of jobs."""
    executors: dict[str, Callable[[str, int], Executor]] = {"pool": lambda runs, jobs: ProcessPool(jobs, runs, False)}
    if ray:
        from slam.sweep.ray_cluster import LOCAL, RayCluster

        executors["Ray"] = lambda runs, jobs: RayCluster(LOCAL, jobs, runs, False)
    return executors
