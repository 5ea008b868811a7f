"""Readings of a lidar from true ranges: noise by name, drop-outs, limits and steps."""

from collections.abc import Callable
from typing import Final

import numpy as np

from sim.realistic_noise import realistic_ranges
from slam.compiled import compiled_on_views
from slam.lidars import LidarModel
from slam.pose import FloatArray
from slam.scenario.lidar_config import LidarConfig, NoiseName


def measure(ranges: FloatArray, time: float, config: LidarConfig, rng: np.random.Generator) -> FloatArray:
    """Turn true ranges (N,), metres, inf without an obstacle, into readings, ``time`` seconds after the start.

    Calls with the same number of beams and the same ``noise`` draw the same number of random numbers.
    """
    normal, uniform = rng.standard_normal(len(ranges)), rng.random(len(ranges))
    ranges = NOISES[config.noise](ranges, normal, time, config, rng)
    if config.dropout:
        ranges = np.where(uniform < config.dropout, np.inf, ranges)
    return quantised(ranges, config.description)


def _table_1(
    ranges: FloatArray, normal: FloatArray, time: float, config: LidarConfig, rng: np.random.Generator
) -> FloatArray:
    model = config.description
    return _within(ranges, normal, (model.near_accuracy, model.near_range, model.far_accuracy), config.bound_sigmas)


def _data_sheet(
    ranges: FloatArray, normal: FloatArray, time: float, config: LidarConfig, rng: np.random.Generator
) -> FloatArray:
    model = config.description
    accuracy = (model.near_accuracy, model.near_range, model.far_accuracy)
    return _within(ranges, normal, model.noise or accuracy, config.bound_sigmas)


def _realistic(
    ranges: FloatArray, normal: FloatArray, time: float, config: LidarConfig, rng: np.random.Generator
) -> FloatArray:
    increment, beams = config.description.lidar.angle_increment, len(ranges)
    lost, edge = rng.random(beams), rng.random(beams)
    return realistic_ranges(ranges, increment, time, config.reflectivity, normal, lost, edge)


Noise = Callable[[FloatArray, FloatArray, float, LidarConfig, np.random.Generator], FloatArray]
"""Function that returns noisy ranges (N,) from true ranges, N normal random numbers, the time and the lidar.

It may draw more random numbers.
"""
NOISES: Final[dict[NoiseName, Noise]] = {
    "paper": _table_1,
    "datasheet": _data_sheet,
    "realistic": _realistic,
    "none": lambda ranges, *_: ranges,
}
"""Every kind of noise by its name in the scenario."""


def quantised(ranges: FloatArray, model: LidarModel) -> FloatArray:
    """Round ranges (N,) to the nearest step from ``range_min``, in whole micrometres, which logs keep exactly.

    Ranges above ``range_max`` become inf, below ``range_min`` -inf (REP-117).
    """
    stepped = np.array(ranges, np.float64)
    quantise(stepped, model.lidar.range_min, model.lidar.range_max, model.resolution)
    return np.round(stepped, 6)


def _within(ranges: FloatArray, normal: FloatArray, bound: tuple[float, float, float], sigmas: float) -> FloatArray:
    """Add Gaussian noise, bounded in standard deviations: near (m) up to near_range (m), far x range beyond."""
    near, near_range, far = bound
    noisy = np.array(ranges, np.float64)
    add_bounded_noise(noisy, near / sigmas, near_range, far / sigmas, normal)
    return noisy


@compiled_on_views
def add_bounded_noise(ranges: FloatArray, near: float, near_range: float, far: float, normal: FloatArray) -> None:
    """Add Gaussian noise: standard deviation ``near`` metres up to ``near_range``, ``far`` times the range beyond."""
    for j in range(len(ranges)):
        sigma = near if ranges[j] <= near_range else far * ranges[j]
        ranges[j] = ranges[j] + sigma * normal[j] if ranges[j] < np.inf else np.inf


@compiled_on_views
def quantise(ranges: FloatArray, range_min: float, range_max: float, resolution: float) -> None:
    """Round ranges (N,) in place, as ``quantised`` does except for the last bits."""
    last = np.rint((range_max - range_min) / resolution)
    for j in range(len(ranges)):
        steps = np.rint((ranges[j] - range_min) / resolution)
        stepped = min(range_min + steps * resolution, range_max)
        outside = -np.inf if steps < 0.0 else np.inf
        ranges[j] = stepped if 0.0 <= steps <= last else (outside if steps == steps else np.nan)
