"""The segments of a scan by chi-square: this project's own method.

Walls are found from the bottom up (wall_runs.py) and fitted to the ranges by the noise of the sensor, which gives every
segment its covariance (wall_lines.py). An end where two walls meet is the corner of their lines; any other end is the
intersection of its beam with the line.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.config import ChiSquareConfig
from slam.lines.learnt_noise import LearntNoise
from slam.lines.range_noise import RangeNoise
from slam.lines.segments import IntArray, Segments
from slam.lines.wall_lines import END, RHO, START, THETA, wall_lines
from slam.lines.wall_runs import FIRST_POINT, LAST_POINT, wall_runs, wall_runs_of_scans
from slam.pose import FloatArray
from slam.scan import BEARING, LaserScan

BATCH: Final = 64
"""Number of scans per task of a thread."""


def segments_by_chi_square(scan: LaserScan, config: ChiSquareConfig, noise: RangeNoise | None = None) -> Segments:
    """Find the segments of the scan with their covariance, sensor frame; their indices refer to ``scan.points()``.

    ``noise`` is that of its ranges; without it, it is estimated from this one scan and the settings.

    Beams without echo (``inf``, ``nan``, or outside the range limits) are left out; a wall continues behind them if the
    gap is small enough.
    """
    ranges, fan, reach = scan.ranges, scan.fan, scan.reach
    noise = noise or LearntNoise.start(config).observe(scan)
    runs, totals = wall_runs(ranges, fan, reach, noise, config.merge_cost, config.min_points)
    spacing = float(fan[BEARING, -1] - fan[BEARING, 0]) / max(len(ranges) - 1, 1) if len(ranges) else 0.0
    kept, *lines = wall_lines(runs, totals, fan, spacing, config.min_length, config.max_angle_sigma)
    return replace(_as_segments(runs[kept], *lines), noise=noise)


def segments_of_scans(
    scans: Sequence[LaserScan], config: ChiSquareConfig, noise: RangeNoise, threads: int | None = None
) -> tuple[Segments, IntArray]:
    """Find the segments of many scans of one sensor, whose noise is known, on this many threads or on all.

    Those of scan i have the indices ``begins[i]`` to ``begins[i + 1]``, exclusive; begins: (scans + 1,).
    """
    batches = [scans[k : k + BATCH] for k in range(0, len(scans), BATCH)]
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        runs, counts, *lines = zip(
            *pool.map(partial(_lines_of_batch, config=config, noise=noise), batches), strict=True
        )
    begins = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
    return _as_segments(np.concatenate(runs), *map(np.concatenate, lines)), begins


def _lines_of_batch(scans: Sequence[LaserScan], config: ChiSquareConfig, noise: RangeNoise) -> tuple[NDArray[Any], ...]:
    """Find the runs in these scans.

    Return segments per scan, lines, their covariance, ends, and the ends' covariance.
    """
    first = scans[0]
    ranges, reach = np.stack([scan.ranges for scan in scans]), first.reach
    runs, totals, counts = wall_runs_of_scans(ranges, first.fan, reach, noise, config.merge_cost, config.min_points)
    used = np.arange(runs.shape[1]) < counts[:, None]
    runs, totals = runs[used], totals[used]
    kept, *lines = wall_lines(runs, totals, first.fan, first.angle_increment, config.min_length, config.max_angle_sigma)
    counts = np.diff(np.searchsorted(kept, np.concatenate([[0], np.cumsum(counts)])))
    return runs[kept], counts, *lines


def _as_segments(
    runs: IntArray, line: FloatArray, line_cov: FloatArray, ends: FloatArray, ends_cov: FloatArray
) -> Segments:
    return Segments(
        runs[:, FIRST_POINT], runs[:, LAST_POINT], line[:, RHO], line[:, THETA], ends[:, START], ends[:, END],
        line_cov, ends_cov[:, START], ends_cov[:, END],
    )  # fmt: skip
