"""Readings of a lidar from true ranges, as in ``sim/lidar_noise.py``, with a robot's own random numbers."""

from typing import Any

import numpy as np

from sim.batch.worlds import GAUSSIAN, REALISTIC, Timing
from sim.lidar_noise import add_bounded_noise, quantise
from sim.random_stream import fill_normal, fill_uniform
from sim.realistic_noise import realistic_ranges
from slam.compiled import compiled, compiled_on_views
from slam.pose import FloatArray


@compiled_on_views
def disturb(ranges: FloatArray, sensor: Any, timing: Timing, time: float, base: Any, numbers: FloatArray) -> None:
    """Turn ranges (B,) into readings with noise, drop-outs, limits and rounding; ``time`` seconds after the start.

    ``numbers`` (3, B) is overwritten.
    """
    if sensor.noise == GAUSSIAN:
        base.stream = fill_normal(base.stream, numbers[0])
        add_bounded_noise(ranges, sensor.near_sigma, sensor.near_range, sensor.far_sigma_per_metre, numbers[0])
    elif sensor.noise == REALISTIC:
        base.stream = fill_normal(base.stream, numbers[0])
        base.stream = fill_uniform(base.stream, numbers[1])
        base.stream = fill_uniform(base.stream, numbers[2])
        _disturb_realistically(ranges, timing.angle_increment, time, sensor.reflectivity, numbers)
    if sensor.dropout > 0.0:
        base.stream = fill_uniform(base.stream, numbers[0])
        for j in range(len(ranges)):
            ranges[j] = np.inf if numbers[0, j] < sensor.dropout else ranges[j]
    quantise(ranges, timing.range_min, timing.range_max, timing.resolution)


@compiled
def _disturb_realistically(
    ranges: FloatArray, step: float, time: float, reflectivity: float, numbers: FloatArray
) -> None:
    ranges[:] = realistic_ranges(ranges, step, time, reflectivity, numbers[0], numbers[1], numbers[2])
