"""``hopslam bench lines``: line extractors side by side, on simulated scans with known walls or on a recorded log."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from slam.bench import log_score
from slam.bench.line_extractors import (
    OURS,
    LineExtractor,
    compared_extractors,
    extract_in_turn,
    ours_by_knowledge,
    ours_learning,
    ours_of_noise,
)
from slam.bench.line_score import LineScore, score_lines, total_score
from slam.bench.line_times import time_table
from slam.bench.scenes import HELD_OUT_SEEDS, NOISE_LEVELS, Scene, scenes
from slam.bench.stopwatch import microseconds
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.files.logs import read_log
from slam.lidars import URG04LX
from slam.pose import FloatArray
from slam.run.log_lines import chi_square_config

_COLUMNS: Final = (
    "method", "F1 %", "TP %", "FP %", "angle\ndeg", "off\nmm", "ends\nmm", "time\nus", "p99\nus", "x\nours",
)  # fmt: skip
_NOTES: Final = (
    "TP: walls found. FP: segments that are not a wall. Angle, offset and time: medians; ends: median and 90 %. Times "
    "are of one scan of 682 beams; x ours: time over ours. Ours gets the noise of the sensor, except in the last rows. "
    "No sensor: it learns the noise, from this scan only or from 50 scans of other rooms. Noise x 1/3 at first: it "
    "starts with a third of the sensor's noise, and learns from 10 scans of other rooms. Noise x 1/3, noise x 2: it "
    "gets a third of the sensor's noise, or twice that noise, and does not learn. "
    '"paper, tuned", split-and-merge, RANSAC and Hough were tuned for each level on other seeds.'
)


@dataclass(frozen=True, slots=True, eq=False)
class _Comparison:
    """Result of one extractor at one level of noise."""

    method: str
    score: LineScore
    times: FloatArray
    """Seconds per scan."""


def scene_tables(seeds: int, console: Terminal) -> list[ResultTable]:
    """Make the tables of each level of noise, from the first ``seeds`` held-out seeds of each family."""
    used = HELD_OUT_SEEDS[:seeds]
    tables = []
    with console.progress() as bar:
        for noise_level, noise in NOISE_LEVELS.items():
            extractors = (*compared_extractors(ours_of_noise(noise), noise_level), *ours_by_knowledge(noise_level))
            seen = list(scenes(used, noise_level))
            task = bar.add_task(f"noise {noise_level}", total=len(seen))
            tables.append(_table(noise_level, _compare(seen, extractors, partial(bar.advance, task)), used))
    with console.waiting("timing"):
        tables.append(time_table(seeds))
    return tables


def log_tables(path: Path, console: Terminal, sensor: str | None = None) -> list[ResultTable]:
    """Make the table of a recorded log; this project's extractor learns the noise, starting from the named sensor's."""
    extractors = compared_extractors(ours_learning(chi_square_config(sensor)))
    log = read_log(path)
    console.print(log.report)
    with console.progress() as bar:
        task = bar.add_task(path.name, total=len(log_score.sampled_scans(log)))
        return [log_score.log_table(path.name, log, log_score.score_log(log, extractors, partial(bar.advance, task)))]


def _compare(
    scenes: Sequence[Scene], extractors: Sequence[LineExtractor], advance: Callable[[], object]
) -> list[_Comparison]:
    """Run the extractors on all of these scenes, in turn on each; ``advance`` is called after every scene."""
    scores: list[list[LineScore]] = [[] for _ in extractors]
    times = np.empty((len(extractors), len(scenes)))
    for m, k, segments, taken in extract_in_turn(extractors, [scene.scan for scene in scenes], advance):
        scores[m].append(score_lines(scenes[k].walls, segments))
        times[m, k] = taken
    return [_Comparison(extractor.name, total_score(scores[m]), times[m]) for m, extractor in enumerate(extractors)]


def _table(noise_level: str, comparisons: Sequence[_Comparison], seeds: range) -> ResultTable:
    """Make the table of one level of noise."""
    ours = next(float(np.median(row.times)) for row in comparisons if row.method == OURS)
    return ResultTable(
        f"Noise {noise_level}, {1000 * NOISE_LEVELS[noise_level] * URG04LX.near_accuracy:.1f} mm below 1 m; "
        f"{comparisons[0].times.size} scans, seeds {seeds[0]} to {seeds[-1]}",
        _COLUMNS,
        [_cells(row, ours) for row in comparisons],
        _NOTES,
    )


def _cells(row: _Comparison, ours: float) -> tuple[str, ...]:
    score = row.score
    return (
        row.method,
        *(f"{100 * share:.1f}" for share in (score.f1, score.recall, score.false_share)),
        f"{np.degrees(_percentile(score.angle_errors, 50)):.2f}",
        f"{1e3 * _percentile(score.offsets, 50):.1f}",
        f"{1e3 * _percentile(score.end_errors, 50):.0f}/{1e3 * _percentile(score.end_errors, 90):.0f}",
        *microseconds(row.times, ours),
    )


def _percentile(errors: FloatArray, share: float) -> float:
    return float(np.percentile(errors, share)) if len(errors) else np.nan
