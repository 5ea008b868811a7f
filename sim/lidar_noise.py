"""Readings of a lidar from true ranges: noise by name, drop-outs, limits and steps."""

from collections.abc import Callable
from typing import Final

import numpy as np

from sim.realistic_noise import realistic_ranges
from slam.compiled import compiled_in_order, compiled_on_views
from slam.pose import FloatArray
from slam.scenario.lidar_config import LidarConfig, NoiseName


def measure(ranges: FloatArray, time: float, config: LidarConfig, rng: np.random.Generator) -> FloatArray:
    """Turn true ranges (N,) into readings, metres, at ``time`` seconds after the start.

    A range without an obstacle is inf. Calls with the same number of beams and the same ``noise`` draw the same number
    of random numbers.
    """
    readings, model = np.array(ranges, np.float64), config.description
    normal, uniform = rng.standard_normal(len(ranges)), rng.random(len(ranges))
    NOISES[config.noise](readings, normal, time, config, rng)
    if config.dropout:
        readings[uniform < config.dropout] = np.inf
    quantise_to_micrometres(readings, model.lidar.range_min, model.lidar.range_max, model.resolution)
    return readings


def _table_1(
    ranges: FloatArray, normal: FloatArray, time: float, config: LidarConfig, rng: np.random.Generator
) -> None:
    model, sigmas = config.description, config.bound_sigmas
    add_bounded_noise(ranges, model.near_accuracy / sigmas, model.near_range, model.far_accuracy / sigmas, normal)


def _data_sheet(
    ranges: FloatArray, normal: FloatArray, time: float, config: LidarConfig, rng: np.random.Generator
) -> None:
    model, sigmas = config.description, config.bound_sigmas
    near, near_range, far = model.noise or (model.near_accuracy, model.near_range, model.far_accuracy)
    add_bounded_noise(ranges, near / sigmas, near_range, far / sigmas, normal)


def _realistic(
    ranges: FloatArray, normal: FloatArray, time: float, config: LidarConfig, rng: np.random.Generator
) -> None:
    increment, beams = config.description.lidar.angle_increment, len(ranges)
    lost, edge = rng.random(beams), rng.random(beams)
    ranges[:] = realistic_ranges(ranges, increment, time, config.reflectivity, normal, lost, edge)


Noise = Callable[[FloatArray, FloatArray, float, LidarConfig, np.random.Generator], None]
"""Function that adds noise to true ranges (N,) in place, from N normal random numbers, the time and the lidar.

It may draw more random numbers.
"""
NOISES: Final[dict[NoiseName, Noise]] = {
    "paper": _table_1,
    "datasheet": _data_sheet,
    "realistic": _realistic,
    "none": lambda *_: None,
}
"""Every kind of noise by its name in the scenario."""


@compiled_on_views
def add_bounded_noise(
    ranges: FloatArray, near_sigma: float, near_range: float, far_sigma_per_metre: float, normal: FloatArray
) -> None:
    """Add Gaussian noise: its standard deviation is constant up to ``near_range``, and grows with the range beyond."""
    for j in range(len(ranges)):
        sigma = near_sigma if ranges[j] <= near_range else far_sigma_per_metre * ranges[j]
        ranges[j] = ranges[j] + sigma * normal[j] if ranges[j] < np.inf else np.inf


@compiled_in_order
def quantise_to_micrometres(ranges: FloatArray, range_min: float, range_max: float, resolution: float) -> None:
    """Quantise ranges (N,) in place, in whole micrometres, which logs keep exactly."""
    quantise(ranges, range_min, range_max, resolution)
    for j in range(len(ranges)):
        ranges[j] = np.rint(ranges[j] * 1e6) / 1e6


@compiled_on_views
def quantise(ranges: FloatArray, range_min: float, range_max: float, resolution: float) -> None:
    """Round ranges (N,) in place to the nearest step from ``range_min``.

    Ranges above ``range_max`` become inf, below ``range_min`` -inf (REP-117).
    """
    last = np.rint((range_max - range_min) / resolution)
    for j in range(len(ranges)):
        steps = np.rint((ranges[j] - range_min) / resolution)
        stepped = min(range_min + steps * resolution, range_max)
        outside = -np.inf if steps < 0.0 else np.inf
        ranges[j] = stepped if 0.0 <= steps <= last else (outside if steps == steps else np.nan)
