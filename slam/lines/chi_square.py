"""The segments of a scan by chi-square: this project's own method.

Walls are found from the bottom up (wall_runs.py) and fitted to the ranges by the noise of the sensor, which gives every
segment its covariance (wall_lines.py). An end where two walls meet is the corner of their lines; any other end is where
its beam meets the line.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.config import ChiSquareConfig
from slam.lines.range_noise import RangeNoise, noise_of_scan, noise_of_sensor
from slam.lines.segments import IntArray, Segments
from slam.lines.wall_lines import wall_lines
from slam.lines.wall_runs import wall_runs, wall_runs_of_many
from slam.pose import FloatArray
from slam.scan import LaserScan, even_fan

PART: Final = 64
"""Scans that a thread takes at a time."""


def segments_by_chi_square(scan: LaserScan, config: ChiSquareConfig) -> Segments:
    """Segments of the scan with their covariance, sensor frame; they count its points as ``scan.points()`` does.

    Beams without echo (``inf``, ``nan``, or outside the reach of the sensor) are left out; a wall goes on behind them
    where the gap allows it.
    """
    fan = fan_of(scan)
    return _segments(scan.ranges, fan, (scan.range_min, scan.range_max), config)


def segments_of_beams(bearings: FloatArray, ranges: FloatArray, config: ChiSquareConfig) -> Segments:
    """The same for beams (N,) in any order and at any spacing; radians and metres.

    They are sorted by bearing first; ``first`` and ``last`` count those with a range above 0 in that order.
    """
    order = np.argsort(bearings, kind="stable")
    t = bearings[order]
    return _segments(ranges[order], np.stack([t, np.cos(t), np.sin(t)]), (1e-6, 1e6), config)


def segments_of_scans(
    scans: Sequence[LaserScan], config: ChiSquareConfig, threads: int | None = None
) -> tuple[Segments, IntArray]:
    """Segments of many scans of one sensor, on this many threads, or on all; ``config.sensor`` is required.

    Those of scan i are the places ``begins[i]`` to ``begins[i + 1]``, exclusive, of the segments; begins: (scans + 1,).
    """
    if config.sensor is None:
        raise ValueError("scans are extracted together only for a sensor of known noise; set sensor")
    parts = [scans[k : k + PART] for k in range(0, len(scans), PART)]
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        runs, counts, *lines = zip(*pool.map(partial(_lines_of_part, config=config), parts), strict=True)
    begins = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
    return _as_segments(np.concatenate(runs), *map(np.concatenate, lines)), begins


def _lines_of_part(scans: Sequence[LaserScan], config: ChiSquareConfig) -> tuple[NDArray[Any], ...]:
    """Runs, segments a scan, lines, their covariance, ends, theirs: of scans that one thread works on."""
    first, noise = scans[0], _noise(config)
    assert noise is not None
    fan = even_fan(first.angle_min, first.angle_increment, len(first.ranges))
    ranges, reach = np.stack([scan.ranges for scan in scans]), (first.range_min, first.range_max)
    runs, totals, counts = wall_runs_of_many(ranges, fan, reach, noise, config.merge_cost, config.min_points)
    used = np.arange(runs.shape[1]) < counts[:, None]
    runs, totals = runs[used], totals[used]
    kept, *lines = wall_lines(runs, totals, fan, first.angle_increment, config.min_length, config.max_angle_sigma)
    counts = np.diff(np.searchsorted(kept, np.concatenate([[0], np.cumsum(counts)])))
    return runs[kept], counts, *lines


def _segments(ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], config: ChiSquareConfig) -> Segments:
    noise = _noise(config) or noise_of_scan(fan[0], ranges, reach, config.shared_error)
    runs, totals = wall_runs(ranges, fan, reach, noise, config.merge_cost, config.min_points)
    spacing = float(fan[0, -1] - fan[0, 0]) / max(len(ranges) - 1, 1) if len(ranges) else 0.0
    kept, *lines = wall_lines(runs, totals, fan, spacing, config.min_length, config.max_angle_sigma)
    return replace(_as_segments(runs[kept], *lines), noise=noise)


def _as_segments(
    runs: IntArray, line: FloatArray, line_cov: FloatArray, ends: FloatArray, ends_cov: FloatArray
) -> Segments:
    return Segments(
        runs[:, 0], runs[:, 1], line[:, 0], line[:, 1], ends[:, 0], ends[:, 1],
        line_cov, ends_cov[:, 0], ends_cov[:, 1],
    )  # fmt: skip


def fan_of(scan: LaserScan) -> FloatArray:
    """Bearings of the beams of a scan, their cosines and sines, shape (3, N); not to be written to."""
    if scan.beam_fan is None:
        return even_fan(scan.angle_min, scan.angle_increment, len(scan.ranges))
    return scan.beam_fan


def _noise(config: ChiSquareConfig) -> RangeNoise | None:
    return None if config.sensor is None else _noise_of_sensor(config.sensor, config.bound_sigmas)


_noise_of_sensor = lru_cache(noise_of_sensor)
