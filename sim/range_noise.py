"""From the true ranges to those a lidar reports: noise, drop-outs, limits and steps."""

from __future__ import annotations

import numpy as np

from slam.lidars import LidarModel
from slam.pose import FloatArray
from slam.run.scenario.lidar_config import LidarConfig


def measure(ranges: FloatArray, config: LidarConfig, rng: np.random.Generator) -> FloatArray:
    """What the lidar makes of these true ranges (N,), metres, inf where nothing stands.

    The noise is Gaussian; the maker's bound for the range (Table 1: 25 mm up to 1 m, 2.5 % beyond) is ``bound_sigmas``
    standard deviations. Any call with the same number of beams draws as many random numbers.
    """
    normal, uniform = rng.standard_normal(len(ranges)), rng.random(len(ranges))
    measured = np.where(uniform < config.dropout, np.inf, ranges)
    if config.noise == "table1":
        echoes = np.isfinite(measured)
        sigmas = config.description.accuracy(measured[echoes]) / config.bound_sigmas
        measured[echoes] += sigmas * normal[echoes]
    return quantised(measured, config.description)


def quantised(ranges: FloatArray, model: LidarModel) -> FloatArray:
    """Ranges (N,) to the nearest step from ``range_min``; beyond the reach inf, closer than that -inf (REP-117)."""
    lidar = model.lidar
    steps = np.rint((ranges - lidar.range_min) / model.resolution)
    last = np.rint((lidar.range_max - lidar.range_min) / model.resolution)
    rounded = np.minimum(lidar.range_min + steps * model.resolution, lidar.range_max)
    return np.select([steps < 0, steps > last], [-np.inf, np.inf], rounded)
