"""Tables of logs run with and without loop closing: errors, loops, costs."""

from collections.abc import Sequence
from math import isnan
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from slam.bench.log_runs import LOGS
from slam.bench.loops.log_results import RANGE_NOISE, LogResult, TrajectoryScore, run_log_both_ways
from slam.bench.loops.place_hits import RANKS
from slam.bench.stopwatch import milliseconds
from slam.bench.worker_pool import run_in_workers
from slam.config import SlamConfig
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal

TABLE_LOGS: Final = ("fr079", "fr101", "belgioioso", "corridor_synthetic", "aces", "duke_loop5")
NOISY_LOGS: Final = ("aces",)
"""Logs for which one run is not significant: they are run again with noise on the ranges."""


class Published(NamedTuple):
    """Mean error of the relations of a log, metres: Hess et al., ICRA 2016, tables II and III."""

    scan_matching: float
    particles: float
    graph_mapping: float
    cartographer: float


PUBLISHED: Final = {"aces": Published(0.173, 0.060, 0.044, 0.0375), "fr079": Published(0.258, 0.061, 0.056, 0.0452)}


def log_tables(
    names: Sequence[str], folder: Path, seeds: int, config: SlamConfig, console: Terminal
) -> list[ResultTable]:
    """Run the logs of these names in the folder with loops and without; without names, those of the project's table.

    NOISY_LOGS also run with ``seeds`` seeds of noise. Missing logs are skipped.
    """
    paths = []
    for name in names or TABLE_LOGS:
        path = folder / LOGS.get(name, name)
        if path.is_file():
            paths.append(path)
        else:
            console.print(f"{name}: no {path}; skipped")
    jobs = [(path, config, seed) for path in paths for seed in range(1 + seeds * (_name(path) in NOISY_LOGS))]
    found = run_in_workers(run_log_both_ways, jobs, "logs, with loops and without", console)
    if not found:
        return []
    plain = [result for result, (*_, seed) in zip(found, jobs, strict=True) if not seed]
    noisy = [result for result, (*_, seed) in zip(found, jobs, strict=True) if seed]
    tables = [error_table(plain), loop_table(plain), place_table(plain), cost_table(plain)]
    return [*tables, noise_table(noisy)] if noisy else tables


def cell(value: float, digits: int = 4) -> str:
    """Format a number; nan becomes an empty text."""
    return "" if isnan(value) else f"{value:.{digits}f}"


def total_time(result: LogResult) -> float:
    """Processor time of a run with loops, until its closed map is complete, seconds."""
    return result.live_total + result.finish_time


def error_table(results: Sequence[LogResult]) -> ResultTable:
    """Make the table of the errors of each log."""
    columns = (
        "log", "measure", "loops\nnever", "live", "final", "seconds", "scan\nmatching", "particles", "graph\nmapping",
        "Carto-\ngrapher",
    )  # fmt: skip
    notes = (
        "Live: the poses as estimated at each scan. Final: the poses after the last scan. Seconds: processor time of "
        "the whole run. Relations: mean error, metres, for the poses of the log; of the centre: the same for the "
        "robot's centre. ATE: metres, after alignment. Open: error of the last poses against the first, by matching "
        "their scans. Off axes: root mean square deviation of the walls from the main directions. Crisp: occupied 5 "
        "cm cells for every 1000 points, fewer are better. The last four columns are the relations of Hess et al., "
        "2016; for aces they stand in the row of ATE, which is another measure."
    )
    rows = [row for result in results for row in _error_rows(result)]
    return ResultTable("Loops closed on recorded logs", columns, rows, notes)


def _error_rows(result: LogResult) -> list[tuple[str, ...]]:
    scores = result.unclosed, result.live, result.final
    published = [f"{value:.4f}" for value in PUBLISHED.get(result.name, ())] or [""] * 4
    rows = []
    if not isnan(result.final.relations):
        rows.append(("relations", *(cell(score.relations) for score in scores), "", *published))
        rows.append(("... of the centre", *(cell(score.centre) for score in scores), "", *[""] * 4))
    if not isnan(result.final.ate):
        shown = published if not rows else [""] * 4
        rows.append(("ATE", *(cell(score.ate) for score in scores), "", *shown))
    if result.final.gap is not None:
        rows.append(("open, m", *(_gap(score) for score in scores), *[""] * 5))
        rows.append(("open, deg", *(_turn(score) for score in scores), *[""] * 5))
        angles = [cell(float(np.degrees(rms)), 2) for rms in (result.unclosed_off_axes, result.final_off_axes)]
        rows.append(("off axes, deg", angles[0], "", angles[1], *[""] * 5))
    rows.append(("crisp", *(cell(score.crisp, 1) for score in scores), *[""] * 5))
    rows[0] = (*rows[0][:4], f"{total_time(result):.1f}", *rows[0][5:])
    return [(result.name if k == 0 else "", *row) for k, row in enumerate(rows)]


def _gap(score: TrajectoryScore) -> str:
    return "" if score.gap is None else f"{np.hypot(score.gap.along, score.gap.across):.2f}"


def _turn(score: TrajectoryScore) -> str:
    return "" if score.gap is None else f"{abs(np.degrees(score.gap.turn)):.2f}"


def noise_table(results: Sequence[LogResult]) -> ResultTable:
    """Make the table of the runs with noise, one row for all runs of a log."""
    rows = []
    for name in dict.fromkeys(result.name for result in results):
        group = [result for result in results if result.name == name]
        ates = np.array([[score.ate for score in (run.unclosed, run.live, run.final)] for run in group])
        for label, row in (("median", np.median(ates, axis=0)), ("worst", ates.max(axis=0))):
            rows.append((f"{name}, {label} of {len(group)}", *map(cell, row)))
    columns = ("log", "loops never\nATE, m", "live\nATE, m", "final\nATE, m")
    return ResultTable("With noise on the ranges", columns, rows, f"White noise of {1e3 * RANGE_NOISE:g} mm.")


def loop_table(results: Sequence[LogResult]) -> ResultTable:
    """Make the table of the loops that were found."""
    columns = ("log", "tried", "accepted", "judged", "wrong", "believed", "wrong,\nbelieved")
    notes = (
        "Judged: loops that the reference covers. Wrong: the median error over the pairs of their scans is more than "
        "0.5 m or 6 deg. Believed: edges that keep more than half of their weight in the graph."
    )
    rows = [(result.name, *map(str, result.loops)) for result in results if result.loops is not None]
    return ResultTable("The loops", columns, rows, notes)


def place_table(results: Sequence[LogResult]) -> ResultTable:
    """Make the table of places proposed from walls alone."""
    columns = ("log", "pairs", *(f"among the\nfirst {rank}" for rank in RANKS), "ms\na pair")
    rows = [
        (
            result.name, str(found.pairs), *(f"{hits / found.pairs:.2f}" for hits in found.hits),
            f"{1e3 * found.seconds / found.pairs:.2f}",
        )
        for result in results
        if (found := result.places) is not None and found.pairs
    ]  # fmt: skip
    notes = (
        "Pairs: submaps at most 4 m apart, with a path of at least 12 m between them. Among the first: share of the "
        "pairs whose true relative pose is among that many proposals."
    )
    return ResultTable("Places from walls alone", columns, rows, notes)


def cost_table(results: Sequence[LogResult]) -> ResultTable:
    """Make the table of processor times."""
    columns = ("log", "scans", "never\nms", "p99", "auto\nms", "p99", "after the\nlast scan, s", "all\nratio")
    notes = (
        "Processor time of an update in the calling thread, extraction included; each scan is given to one mode and "
        "then to the other. Ratio: processor time of all threads with loops, from the first scan to the closed map, "
        "divided by that without loops."
    )
    rows = [
        (
            result.name, str(result.scans), *milliseconds(result.unclosed_times), *milliseconds(result.live_times),
            f"{result.finish_time:.2f}", f"{total_time(result) / result.unclosed_times.sum():.2f}",
        )
        for result in results
    ]  # fmt: skip
    return ResultTable("Costs of loops", columns, rows, notes)


def _name(path: Path) -> str:
    return path.name.split(".")[0]
