"""Readings of a lidar from true ranges, as ``sim/lidar_noise.py`` makes them, from a robot's own random numbers."""

from typing import Any

import numpy as np

from sim.batch.worlds import GAUSSIAN, REALISTIC, Timing
from sim.lidar_noise import bounded_noise, quantised_steps
from sim.random_stream import fill_normal, fill_uniform
from sim.realistic_noise import realistic_ranges
from slam.compiled import compiled
from slam.pose import FloatArray


@compiled
def readings(ranges: FloatArray, sensor: Any, timing: Timing, time: float, base: Any) -> FloatArray:
    """Ranges (B,) with noise, drop-outs, limits and steps; ``time`` seconds after the start."""
    numbers = np.empty(len(ranges))
    if sensor.noise == GAUSSIAN:
        base.stream = fill_normal(base.stream, numbers)
        ranges = bounded_noise(ranges, sensor.near, sensor.near_range, sensor.far, numbers)
    elif sensor.noise == REALISTIC:
        lost, edge = np.empty(len(ranges)), np.empty(len(ranges))
        base.stream = fill_normal(base.stream, numbers)
        base.stream = fill_uniform(base.stream, lost)
        base.stream = fill_uniform(base.stream, edge)
        ranges = realistic_ranges(ranges, timing.step, time, sensor.reflectivity, numbers, lost, edge)
    if sensor.dropout > 0.0:
        base.stream = fill_uniform(base.stream, numbers)
        ranges = np.where(numbers < sensor.dropout, np.inf, ranges)
    return quantised_steps(ranges, timing.range_min, timing.range_max, timing.resolution)
