"""The noise of a lidar's ranges, and that of a sensor given by name."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from slam.compiled import compiled_on_views
from slam.lidars import LIDARS, LidarName
from slam.pose import FloatArray

ROUGHNESS = 0.01  # metres by which real walls are not flat


class RangeNoise(NamedTuple):
    """Standard deviation of a range: ``near`` metres up to ``near_range``, ``far`` times the range beyond.

    ``floor`` metres are added in quadrature, for walls that are not flat.
    """

    near: float
    near_range: float
    far: float
    floor: float

    def sigma(self, ranges: FloatArray) -> FloatArray:
        """Return the standard deviation at these ranges, all in metres."""
        return np.asarray(np.hypot(np.where(ranges <= self.near_range, self.near, self.far * ranges), self.floor))


@lru_cache
def noise_of_sensor(name: LidarName, bound_sigmas: float) -> RangeNoise:
    """Return the noise for a maker's bound of ``bound_sigmas`` standard deviations."""
    model = LIDARS[name]
    return RangeNoise(
        model.near_accuracy / bound_sigmas,
        model.near_range,
        model.far_accuracy / bound_sigmas,
        ROUGHNESS,
    )


@compiled_on_views
def range_variance(r: float, noise: RangeNoise) -> float:
    """Return the square of ``RangeNoise.sigma`` at one range, m^2, for compiled code."""
    near, near_range, far, floor = noise
    slope = near if r <= near_range else far * r
    return slope * slope + floor * floor
