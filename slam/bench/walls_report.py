"""``hopslam bench walls``: the line map against the true walls, compared with other line maps of the same poses."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from typing import Final

import numpy as np

from slam.bench.sim_runs import CASTER, repeating_command
from slam.bench.wall_map_runs import LINE_MAPS, OURS, WallMapRun, run_wall_map, total_score
from slam.bench.worker_pool import run_in_workers
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.run.scoring.wall_score import WallScore

SCENARIOS: Final = ("cluttered_room", "random_office", "office_loop", "corridor")


def wall_tables(
    names: Sequence[str],
    seeds: Sequence[int],
    settings: tuple[str, ...],
    console: Terminal,
    allow_modules: tuple[str, ...] = (),
) -> list[ResultTable]:
    """Drive every scenario, shipped or a file, by default four, with these seeds."""
    run = partial(run_wall_map, settings=(CASTER, *settings), allow_modules=allow_modules)
    again = partial(repeating_command, settings=settings, allow_modules=allow_modules)
    jobs = list(product(names or SCENARIOS, seeds))
    found = run_in_workers(run, jobs, "driving in the simulator", console)
    runs = [(*job, run) for job, run in zip(jobs, found, strict=True)]
    groups = {name: [(seed, run) for other, seed, run in runs if other == name] for name, *_ in runs}
    return [_map_table(groups), _worst_table(groups, again)]


def _map_table(groups: dict[str, list[tuple[int, WallMapRun]]]) -> ResultTable:
    columns = (
        "scenario", "lines", "precision", "recall", "length\ncm", "ends\ncm", "90 %\ncm", "doubled\nm a run",
        "free air\nm a run", "longest\nphantom, m",
    )  # fmt: skip
    notes = (
        "All seeds together. Precision: share of the mapped length within 0.1 m of a true wall that faces the same "
        "side. Recall: share of the walls seen by three scans that is mapped. Length: median error of walls seen "
        "whole. Ends: distance from their ends to the nearest line on the wall. All segments: every segment of every "
        "mapped scan, as in the paper. Split-and-merge: its segments, merged into lines. All maps use the same poses."
    )
    rows = [
        (name, way, *_cells(total_score([run.scores[way] for _, run in runs]), len(runs)))
        for name, runs in groups.items()
        for way in LINE_MAPS
    ]
    return ResultTable("Line maps against the true walls", columns, rows, notes)


def _cells(score: WallScore, runs: int) -> tuple[str, ...]:
    lengths, ends = 100.0 * np.abs(score.length_errors), 100.0 * score.end_errors
    return (
        *_shares(score), f"{np.median(lengths):.1f}" if len(lengths) else "-",
        f"{np.median(ends):.1f}" if len(ends) else "-", f"{np.percentile(ends, 90):.1f}" if len(ends) else "-",
        f"{score.doubled / runs:.2f}", f"{score.free_air / runs:.2f}", f"{score.phantom:.2f}",
    )  # fmt: skip


def _shares(score: WallScore) -> tuple[str, str]:
    return f"{100 * score.precision:.1f} %", f"{100 * score.recall:.1f} %"


def _worst_table(groups: dict[str, list[tuple[int, WallMapRun]]], again: Callable[[str, int], str]) -> ResultTable:
    """List for each scenario the run with the longest phantom, and its command; of several, the least precise one."""
    columns = ("scenario, seed", "ending", "precision", "recall", "free air\nm", "phantom\nm", "command")
    rows = []
    for name, runs in groups.items():
        seed, run = max(runs, key=lambda row: (round(row[1].scores[OURS].phantom, 2), -row[1].scores[OURS].precision))
        score = run.scores[OURS]
        metres = f"{score.free_air:.2f}", f"{score.phantom:.2f}"
        rows.append((f"{name}, {seed}", run.ending, *_shares(score), *metres, again(name, seed)))
    return ResultTable("The worst runs again", columns, rows)
