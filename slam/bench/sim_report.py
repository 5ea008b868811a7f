"""``hopslam bench slam-sim``: errors, covariances and costs in the simulator, also over an hour."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from typing import Final

import numpy as np

from slam.bench.sim_runs import HOUR, SimRun, repeating_command, run_scenario
from slam.bench.stopwatch import milliseconds
from slam.bench.worker_pool import run_in_workers
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.pose import FloatArray

SCENARIOS: Final = (
    "crowded_corridor", "featureless_corridor", "corridor", "office_loop", "cluttered_room", "random_office"
)  # fmt: skip
HOUR_SCENARIO: Final = "office_loop"
"""Scenario of the long run: a loop, so that most of the hour is spent in known places."""
CHI_SQUARE_95: Final = 7.815
"""95 % quantile of chi-square with three degrees of freedom."""
OPEN_SHARE: Final = 0.5
"""A run is in the table of unconstrained runs if more than this share of its scans has an unconstrained direction."""
HOUR_BLOCK: Final = 1000
"""Scans at the beginning and at the end that are compared."""
HOUR_PARTS: Final = 12
"""Number of parts of the hour: five minutes each."""


def sim_tables(
    names: Sequence[str],
    seeds: Sequence[int],
    hour: bool,
    settings: tuple[str, ...],
    console: Terminal,
    allow_modules: tuple[str, ...] = (),
) -> list[ResultTable]:
    """Drive these scenarios, or all, with these seeds.

    With ``hour`` the long run follows last; no other program should run during timing.
    """
    jobs = [(name, seed, settings, False, allow_modules) for name, seed in product(names or SCENARIOS, seeds)]
    results = run_in_workers(run_scenario, jobs, "driving in the simulator", console)
    runs = [(name, seed, result) for (name, seed, *_), result in zip(jobs, results, strict=True)]
    made: list[ResultTable] = []
    if runs:
        again = partial(repeating_command, settings=settings, allow_modules=allow_modules)
        made += [_run_table(runs), _scenario_table(runs), _worst_table(runs, again), *unconstrained_tables(runs)]
    if hour:
        description = f"driving around {HOUR_SCENARIO} for one simulated hour"
        [long_run] = run_in_workers(run_scenario, [(HOUR_SCENARIO, 0, settings, True)], description, console, 1)
        made += hour_tables(long_run)
    return made


def unconstrained_tables(runs: Sequence[tuple[str, int, SimRun]]) -> list[ResultTable]:
    """Make the table of the runs in which most scans left a direction unconstrained; empty without such a run.

    Along that direction there is only odometry; across it the scans must keep the error small.
    """
    chosen = [(name, seed, run) for name, seed, run in runs if run.unconstrained[1:].mean() > OPEN_SHARE]
    if not chosen:
        return []
    found = np.array([_unconstrained_errors(run) for *_, run in chosen])
    labels = [f"{name}, {seed}" for name, seed, _ in chosen]
    summary = [("median", *_cells(np.median(found, axis=0))), ("worst", *_cells(_worst(found)))]
    columns = (
        "scenario, seed", "along\nend, cm", "odometer", "odometry", "across\nmost, cm", "across\nrms, cm",
        "heading\nmost, deg", "open",
    )  # fmt: skip
    notes = (
        "Errors along the line from the first to the last true position, and across it. Odometer: final error along "
        "the line of dead reckoning with the true heading, which no method can avoid there. Odometry: the same with "
        "the heading of the odometry."
    )
    rows = [(label, *_cells(row)) for label, row in zip(labels, found, strict=True)]
    return [ResultTable("Where the scans leave a direction open", columns, [*rows, *summary], notes)]


def hour_tables(run: SimRun) -> list[ResultTable]:
    """Make the tables of cost and memory over the hour: the first scans against the last, and the map over time."""
    return [_hour_cost(run), _map_size(run)]


def _run_table(runs: Sequence[tuple[str, int, SimRun]]) -> ResultTable:
    columns = (
        "scenario, seed", "ending", "scans", "final\ncm", "ATE\ncm", "most\ncm", "most x\ncm", "odometry\nmost x, cm",
        "most y\ncm", "open", "in bound", "lost", "odometry\nonly", "ms", "p99 ms",
    )  # fmt: skip
    notes = (
        "Errors against the truth, without alignment. Open: scans that do not constrain the pose in some direction. In "
        "bound: scans whose normalised squared error is below the 95 % quantile of chi-square. Odometry only: scans "
        "whose match was rejected. Milliseconds: processor time per update, extraction included."
    )
    return ResultTable("In the simulator", columns, [_run_row(*run) for run in runs], notes)


def _run_row(name: str, seed: int, run: SimRun) -> tuple[str, ...]:
    offsets, wheels = 100.0 * np.abs(run.offsets), 100.0 * np.abs(run.odometry_offsets)
    distance = np.hypot(offsets[:, 0], offsets[:, 1])
    return (
        f"{name}, {seed}", run.ending, str(len(run.poses)), f"{distance[-1]:.1f}",
        f"{np.sqrt(np.mean(distance**2)):.1f}", f"{distance.max():.1f}", f"{offsets[:, 0].max():.1f}",
        f"{wheels[:, 0].max():.1f}", f"{offsets[:, 1].max():.1f}", f"{100 * run.unconstrained[1:].mean():.0f} %",
        f"{100 * np.mean(run.normalised_errors < CHI_SQUARE_95):.0f} %", str(run.lost), str(run.odometry_only),
        *milliseconds(run.times),
    )  # fmt: skip


def _scenario_table(runs: Sequence[tuple[str, int, SimRun]]) -> ResultTable:
    groups = {name: [run for other, _, run in runs if other == name] for name, *_ in runs}
    rows = [_scenario_row(name, group) for name, group in groups.items()]
    if len(groups) > 1:
        rows.append(_scenario_row("all", [run for *_, run in runs]))
    columns = ("scenario", "runs", "worst final\ncm", "lost", "in bound", "worst run\nin bound")
    return ResultTable("All seeds together", columns, rows)


def _scenario_row(name: str, runs: Sequence[SimRun]) -> tuple[str, ...]:
    final = max(map(_final, runs))
    bound = [run.normalised_errors < CHI_SQUARE_95 for run in runs]
    lost = sum(run.lost > 0 or run.ending != "arrived" for run in runs)
    shares = np.mean(np.concatenate(bound)), min(map(np.mean, bound))
    return name, str(len(runs)), f"{100 * final:.1f}", str(lost), *(f"{100 * share:.1f} %" for share in shares)


def _worst_table(runs: Sequence[tuple[str, int, SimRun]], again: Callable[[str, int], str]) -> ResultTable:
    """Return the run of each scenario with the largest final error, and the command that repeats it."""
    worst: dict[str, tuple[int, SimRun]] = {}
    for name, seed, run in runs:
        if name not in worst or _final(run) > _final(worst[name][1]):
            worst[name] = seed, run
    rows = [(f"{name}, {seed}", f"{100 * _final(run):.1f}", again(name, seed)) for name, (seed, run) in worst.items()]
    return ResultTable("The worst runs again", ("scenario, seed", "final\ncm", "command"), rows)


def _final(run: SimRun) -> float:
    """Distance from the true pose at the end, metres."""
    return float(np.hypot(*run.offsets[-1, :2]))


def _unconstrained_errors(run: SimRun) -> FloatArray:
    """Errors of one run: centimetres, degrees, and the share of scans with an unconstrained direction."""
    direction = run.truth[-1, :2] - run.truth[0, :2]
    along = direction / np.hypot(*direction)
    across = 100.0 * np.abs(run.offsets[:, :2] @ np.array([-along[1], along[0]]))
    compared = run.offsets, run.true_heading_offsets, run.odometry_offsets
    ends = [abs(100.0 * offsets[-1, :2] @ along) for offsets in compared]
    turned = np.degrees(np.abs(run.offsets[:, 2])).max()
    return np.array([*ends, across.max(), np.sqrt(np.mean(across**2)), turned, run.unconstrained[1:].mean()])


def _worst(found: FloatArray) -> FloatArray:
    """Return the greatest error of each kind, and the least share."""
    return np.append(found[:, :-1].max(axis=0), found[:, -1].min())


def _cells(row: FloatArray) -> list[str]:
    return [*(f"{value:.2f}" for value in row[:-1]), f"{100 * row[-1]:.0f} %"]


def _hour_cost(run: SimRun) -> ResultTable:
    columns = ("scans", "first 1,000\nms", "p99", "last 1,000\nms", "p99", "ratio", "end\ncm", "most\ncm")
    first, last = run.times[:HOUR_BLOCK], run.times[-HOUR_BLOCK:]
    errors = 100.0 * np.hypot(*run.offsets[:, :2].T)
    row = (
        str(len(run.times)), *milliseconds(first), *milliseconds(last), f"{np.median(last) / np.median(first):.2f}",
        f"{errors[-1]:.1f}", f"{errors.max():.1f}",
    )  # fmt: skip
    return ResultTable(
        "One hour", columns, [row], "The robot drives round after round. The first 1,000 scans make the map."
    )


def _map_size(run: SimRun) -> ResultTable:
    ends = [len(run.times) * part // HOUR_PARTS for part in range(1, HOUR_PARTS + 1)]
    rows = [
        (
            f"{end / len(run.times) * HOUR / 60.0:.0f} min", f"{run.map_points[end - 1]:.0f}",
            f"{run.map_bytes[end - 1] / 1e3:.0f}", *milliseconds(run.times[begin:end]),
        )
        for begin, end in zip([0, *ends], ends, strict=False)
    ]  # fmt: skip
    return ResultTable("The map in that hour", ("after", "surfels", "kB", "ms", "p99"), rows)
