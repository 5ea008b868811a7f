"""Tables of drives in the simulator with and without loop closing, and of one hour around a loop."""

from itertools import product
from typing import Final

import numpy as np

from slam.bench.loops.loop_errors import WRONG_METRES, WRONG_RADIANS
from slam.bench.loops.sim_drives import Drive, drive
from slam.bench.stopwatch import milliseconds
from slam.bench.wall_map_runs import total_score
from slam.bench.worker_pool import run_in_workers
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal

FIRST_SEEDS: Final = {"office_loop": 10, "campus_loop": 0}
"""Scenarios, and the first of their seeds."""
LOOP_SETTINGS: Final = {"never": "slam.loops=never", "auto": "slam.loops=auto"}
HOUR_SCENARIO: Final = "office_loop"
MINUTES: Final = 60
PART: Final = 5
"""Minutes per row."""


def sim_tables(seeds: int, settings: tuple[str, ...], console: Terminal) -> list[ResultTable]:
    """Drive around both loops with ``seeds`` seeds each, with and without loop closing."""
    jobs = [
        (name, first + k, way) for (name, first), k, way in product(FIRST_SEEDS.items(), range(seeds), LOOP_SETTINGS)
    ]
    arguments = [(name, seed, (*settings, LOOP_SETTINGS[way])) for name, seed, way in jobs]
    found = dict(zip(jobs, run_in_workers(drive, arguments, "driving around loops", console), strict=True))
    return [_run_table(found), _mean_table(found)] if found else []


def hour_tables(settings: tuple[str, ...]) -> list[ResultTable]:
    """Drive around for an hour, and tabulate every five minutes the cost of a scan and the size of the graph."""
    return [hour_table(drive(HOUR_SCENARIO, 0, (*settings, LOOP_SETTINGS["auto"]), hour=True))]


def hour_table(run: Drive) -> ResultTable:
    """Make the table of the cost of a scan and of the size of the graph over the hour."""
    columns = ("minutes", "ms", "p99", "most, ms", "back end\ns", "key scans", "submaps", "edges", "loops", "MB")
    rows, searched = [], 0.0
    ends = [run.scans * minutes // MINUTES for minutes in range(PART, MINUTES + 1, PART)]
    for minutes, begin, end in zip(range(PART, MINUTES + 1, PART), [0, *ends], ends, strict=False):
        times, size = run.times[begin:end], run.sizes[end - 1]
        rows.append(
            (
                str(minutes), *milliseconds(times), f"{1e3 * times.max():.1f}", f"{size.seconds - searched:.1f}",
                *map(str, size[:4]), f"{size.nbytes / 1e6:.1f}",
            )
        )  # fmt: skip
        searched = size.seconds
    notes = (
        "Processor time of an update of the front end, and of the back end in the same five minutes; MB of key scans. "
        f"The final loop closing takes {run.finish_time:.1f} s; ATE {100 * run.ate:.1f} cm before it, "
        f"{100 * run.final_ate:.1f} cm after it."
    )
    return ResultTable(f"One hour around {HOUR_SCENARIO}", columns, rows, notes)


def _run_table(found: dict[tuple[str, int, str], Drive]) -> ResultTable:
    columns = (
        "scenario, seed", "ending", "odometry\nATE, cm", "never\nATE, cm", "live\nATE, cm", "final\nATE, cm",
        "never\nmost, cm", "final\nmost, cm", "loops", "believed,\nwrong", "after the\nend, s",
    )  # fmt: skip
    rows = []
    for name, seed in dict.fromkeys((name, seed) for name, seed, _ in found):
        never, auto = (found[name, seed, way] for way in LOOP_SETTINGS)
        metres = never.odometry_ate, never.ate, auto.ate, auto.final_ate, never.worst, auto.final_worst
        endings = never.ending if never.ending == auto.ending else f"{never.ending}, {auto.ending}"
        cells = [f"{100 * value:.1f}" for value in metres]
        assert auto.loops is not None
        loops = str(auto.loops.accepted), f"{auto.loops.believed}, {auto.loops.believed_wrong}"
        rows.append((f"{name}, {seed}", endings, *cells, *loops, f"{auto.finish_time:.2f}"))
    notes = (
        "Errors against the truth, without alignment. The robot steers by its own estimate, with loops and without, so "
        f"no two drives are the same. A loop is wrong if it is off by more than {WRONG_METRES} m or "
        f"{np.degrees(WRONG_RADIANS):.0f} deg."
    )
    return ResultTable("Loops driven in the simulator", columns, rows, notes)


def _mean_table(found: dict[tuple[str, int, str], Drive]) -> ResultTable:
    columns = (
        "scenario", "runs", "arrived", "loops", "mean ATE\nlive, cm", "final, cm", "worst ATE\nfinal, cm",
        "wall lengths\nmedian, cm", "in all, %", "wall ends\nmedian, cm", "doubled\nm a run", "loops believed,\nwrong",
    )  # fmt: skip
    rows = []
    for name, way in dict.fromkeys((name, way) for name, _, way in found):
        runs = [run for (other, _, how), run in found.items() if (other, how) == (name, way)]
        live, final = (np.array([getattr(run, kind) for run in runs]) for kind in ("ate", "final_ate"))
        walls = total_score([run.walls for run in runs])
        metres = live.mean(), final.mean(), final.max(), _median(np.abs(walls.length_errors))
        arrived = sum(run.ending == "arrived" for run in runs)
        rows.append(
            (
                name, str(len(runs)), str(arrived), way, *(f"{100 * value:.1f}" for value in metres),
                f"{100 * walls.length_error_share:.2f}", f"{100 * _median(walls.end_errors):.1f}",
                f"{walls.doubled / len(runs):.2f}", _believed(runs),
            )
        )  # fmt: skip
    notes = (
        "Wall lengths and ends: errors of walls that were seen whole, in the final map, which is the closed one with "
        "loops. In all: sum of the length errors, as a share of the length of these walls."
    )
    return ResultTable("All seeds together", columns, rows, notes)


def _believed(runs: list[Drive]) -> str:
    counts = [run.loops for run in runs if run.loops is not None]
    return f"{sum(one.believed for one in counts)}, {sum(one.believed_wrong for one in counts)}" if counts else "-"


def _median(errors: np.ndarray) -> float:
    return float(np.median(errors)) if len(errors) else float("nan")
