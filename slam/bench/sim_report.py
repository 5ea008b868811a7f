"""``hopslam bench slam-sim``: the tables of the runs in the simulator."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Final

import numpy as np

from slam.bench.hour_report import hour_tables
from slam.bench.open_report import open_tables
from slam.bench.sim_runs import SimRun, run_scenario
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal

WORKERS: Final = 2
SCENARIOS: Final = (
    "crowded_corridor", "featureless_corridor", "corridor", "office_loop", "cluttered_room", "random_office"
)  # fmt: skip
HOUR_OF: Final = "office_loop"
"""The route of the long run: a loop, so that most of the hour is in places seen before."""
BOUND: Final = 7.815
"""95 % of chi-square with three degrees of freedom."""


def tables(
    names: Sequence[str],
    seeds: Sequence[int],
    hour: bool,
    settings: tuple[str, ...],
    console: Terminal,
    allow_modules: tuple[str, ...] = (),
) -> list[ResultTable]:
    """Errors of every scenario for these seeds, all scenarios without a name; with ``hour`` also the long run, after
    the others: nothing else should run beside what is timed."""
    jobs = [(name, seed) for name in (names or SCENARIOS) for seed in seeds]
    with ProcessPoolExecutor(WORKERS) as pool:
        futures = [
            (name, seed, pool.submit(run_scenario, name, seed, settings, allow_modules=allow_modules))
            for name, seed in jobs
        ]
        with console.progress() as bar:
            done = bar.track(futures, description="driving in the simulator")
            runs = [(name, seed, future.result()) for name, seed, future in done]
        made = [_each(runs), _together(runs), *open_tables(runs)] if runs else []
        if hour:
            with console.waiting(f"driving around {HOUR_OF} for an hour of its time"):
                made += hour_tables(pool.submit(run_scenario, HOUR_OF, 0, settings, True).result())
        return made


def _each(runs: Sequence[tuple[str, int, SimRun]]) -> ResultTable:
    columns = (
        "scenario, seed", "ending", "scans", "final\ncm", "ATE\ncm", "most\ncm", "most x\ncm", "odometry\nmost x, cm",
        "most y\ncm", "open", "in bound", "lost", "ms", "p99 ms",
    )  # fmt: skip
    notes = (
        "Against the truth, without alignment. Open: scans that left a direction to odometry. In bound: normalised "
        "squared error within 95 % of chi-square. Milliseconds of processor time an update, extraction included."
    )
    return ResultTable("In the simulator", columns, [_row(*run) for run in runs], notes)


def _row(name: str, seed: int, run: SimRun) -> tuple[str, ...]:
    offsets, wheels = 100.0 * np.abs(run.offsets), 100.0 * np.abs(run.odometry_offsets)
    distance = np.hypot(offsets[:, 0], offsets[:, 1])
    return (
        f"{name}, {seed}", run.ending, str(len(run.poses)), f"{distance[-1]:.1f}",
        f"{np.sqrt(np.mean(distance**2)):.1f}", f"{distance.max():.1f}", f"{offsets[:, 0].max():.1f}",
        f"{wheels[:, 0].max():.1f}", f"{offsets[:, 1].max():.1f}", f"{100 * run.open[1:].mean():.0f} %",
        f"{100 * np.mean(run.normalised_errors < BOUND):.0f} %", str(run.lost), f"{1e3 * np.median(run.times):.3f}",
        f"{1e3 * np.percentile(run.times, 99):.2f}",
    )  # fmt: skip


def _together(runs: Sequence[tuple[str, int, SimRun]]) -> ResultTable:
    groups = {name: [run for other, _, run in runs if other == name] for name, *_ in runs}
    rows = [_sum(name, group) for name, group in groups.items()]
    if len(groups) > 1:
        rows.append(_sum("all", [run for *_, run in runs]))
    columns = ("scenario", "runs", "worst final\ncm", "lost", "in bound")
    return ResultTable("All seeds together", columns, rows)


def _sum(name: str, runs: Sequence[SimRun]) -> tuple[str, ...]:
    final = max(float(np.hypot(*run.offsets[-1, :2])) for run in runs)
    errors = np.concatenate([run.normalised_errors for run in runs])
    lost = sum(run.lost > 0 or run.ending != "arrived" for run in runs)
    return name, str(len(runs)), f"{100 * final:.1f}", str(lost), f"{100 * np.mean(errors < BOUND):.1f} %"
