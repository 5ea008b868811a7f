"""The line extractors side by side, on simulated scans with known walls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Final

import numpy as np

from slam.bench.line_score import LineScore, score_lines, total
from slam.bench.methods import OURS, Method
from slam.bench.scenes import NOISE_LEVELS, Scene
from slam.console.result_table import ResultTable
from slam.lidars import URG04LX
from slam.pose import FloatArray
from slam.scan import LaserScan

COLUMNS: Final = (
    "method", "F1 %", "TP %", "FP %", "angle\ndeg", "off\nmm", "ends\nmm", "time\nus", "p99\nus", "x\nours",
)  # fmt: skip
NOTES: Final = (
    "TP: walls found. FP: segments that are no wall. Angle, offset and time: medians; ends: median and 90 %. Times are "
    "of one scan of 682 beams; x ours: time over ours. Ours is told the noise of the sensor, but for the last three "
    'rows; "paper, tuned", split-and-merge, RANSAC and Hough were tuned for each level on other seeds.'
)


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """One method at one level of noise."""

    method: str
    score: LineScore
    times: FloatArray
    """Seconds a scan."""


def compare(scenes: Sequence[Scene], methods: Sequence[Method], advance: Callable[[], object]) -> list[Comparison]:
    """The methods on all of these scenes, in turn on each; ``advance`` is called after every scene."""
    warm_up(scenes[0].scan, methods)
    scores: list[list[LineScore]] = [[] for _ in methods]
    times = np.empty((len(methods), len(scenes)))
    for k, scene in enumerate(scenes):
        for m, method in enumerate(methods):
            began = perf_counter()
            segments = method.extract(scene.scan)
            times[m, k] = perf_counter() - began
            scores[m].append(score_lines(scene.walls, segments))
        advance()
    return [Comparison(method.name, total(scores[m]), times[m]) for m, method in enumerate(methods)]


def warm_up(scan: LaserScan, methods: Sequence[Method]) -> None:
    """Compile what has to be compiled."""
    for method in methods:
        method.extract(scan)


def table(noise_level: str, comparisons: Sequence[Comparison], seeds: range) -> ResultTable:
    """The table of one level of noise."""
    ours = next(float(np.median(row.times)) for row in comparisons if row.method == OURS)
    return ResultTable(
        f"Noise {noise_level}, {1000 * NOISE_LEVELS[noise_level] * URG04LX.near_accuracy:.1f} mm below 1 m; "
        f"{comparisons[0].times.size} scans, seeds {seeds[0]} to {seeds[-1]}",
        COLUMNS,
        [_cells(row, ours) for row in comparisons],
        NOTES,
    )


def _cells(row: Comparison, ours: float) -> tuple[str, ...]:
    score = row.score
    median, p99 = np.median(row.times), np.percentile(row.times, 99)
    return (
        row.method,
        *(f"{100 * share:.1f}" for share in (score.f1, score.recall, score.false_share)),
        f"{np.degrees(_percentile(score.angle_errors, 50)):.2f}",
        f"{1e3 * _percentile(score.offsets, 50):.1f}",
        f"{1e3 * _percentile(score.end_errors, 50):.0f}/{1e3 * _percentile(score.end_errors, 90):.0f}",
        f"{1e6 * median:.0f}",
        f"{1e6 * p99:.0f}",
        f"{median / ours:.1f}",
    )


def _percentile(errors: FloatArray, share: float) -> float:
    return float(np.percentile(errors, share)) if len(errors) else np.nan
