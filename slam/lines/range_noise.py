"""How noisy the ranges of a lidar are: from its description, or from a scan."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from slam.lidars import lidar_model
from slam.pose import FloatArray

UNKNOWN = 0.01  # metres: taken where a scan has too few beams to tell


class RangeNoise(NamedTuple):
    """Standard deviation of a range: ``near`` metres up to ``near_range``, ``far`` times the range beyond; and
    ``floor`` metres on top, in quadrature."""

    near: float
    near_range: float
    far: float
    floor: float

    def sigma(self, ranges: FloatArray) -> FloatArray:
        """Metres, at these ranges (metres)."""
        return np.asarray(np.hypot(np.where(ranges <= self.near_range, self.near, self.far * ranges), self.floor))


def noise_of_sensor(name: str, bound_sigmas: float) -> RangeNoise:
    """What the maker says, whose bound is this many standard deviations; the floor is the step of the range."""
    model = lidar_model(name)
    return RangeNoise(
        model.near_accuracy / bound_sigmas,
        model.near_range,
        model.far_accuracy / bound_sigmas,
        model.resolution / np.sqrt(12.0),
    )


def noise_of_scan(bearings: FloatArray, ranges: FloatArray, shared_error: float) -> RangeNoise:
    """Estimated from a scan of bearings and ranges (N,), all echoes, in order of bearing.

    Neighbours do not show the error that they share, metres; it becomes the floor.

    Along a straight wall 1/r is a sinusoid of the bearing, so with equal steps the second difference
    u(-1) - 2 cos(step) u(0) + u(+1) of u = 1/r is noise alone, of variance 6 sigma^2 / r^4. Corners and gaps are the
    rarer the finer the scan; a median looks past them. The nearer and the farther half of the beams are asked apart: a
    noise that grows from one to the other is taken to grow with the range from half way on.
    """
    step = np.diff(bearings)
    even = np.abs(step[1:] - step[:-1]) < 0.1 * np.abs(step[1:])
    if np.count_nonzero(even) < 8:
        return RangeNoise(UNKNOWN, np.inf, 0.0, shared_error)
    u = 1.0 / ranges
    bend = (u[:-2] - 2.0 * np.cos(step[1:]) * u[1:-1] + u[2:])[even]
    r = ranges[1:-1][even]
    noise = np.abs(bend) * r * r / np.sqrt(6.0)
    middle = float(np.median(r))
    near, far = (float(np.median(noise[half])) / 0.6745 for half in (r <= middle, r >= middle))
    if far <= 1.2 * near:
        return RangeNoise(max(near, far), np.inf, 0.0, shared_error)
    far_slope = far / float(np.median(r[r >= middle]))
    return RangeNoise(near, near / far_slope, far_slope, shared_error)
