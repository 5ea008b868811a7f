"""The noise of a lidar's ranges, from the description of the sensor or estimated from a scan."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from slam.compiled import compiled
from slam.lidars import LIDARS, LidarName
from slam.pose import FloatArray

NORMAL_MEDIAN = 0.6745  # of the absolute value, in standard deviations
UNKNOWN_NOISE = 0.01  # metres: taken where a scan has too few beams to tell


class RangeNoise(NamedTuple):
    """Standard deviation of a range: ``near`` metres up to ``near_range``, ``far`` times the range beyond; and
    ``floor`` metres on top, in quadrature."""

    near: float
    near_range: float
    far: float
    floor: float

    def sigma(self, ranges: FloatArray) -> FloatArray:
        """Return the standard deviation at these ranges, all in metres."""
        return np.asarray(np.hypot(np.where(ranges <= self.near_range, self.near, self.far * ranges), self.floor))


@lru_cache
def noise_of_sensor(name: LidarName, bound_sigmas: float) -> RangeNoise:
    """Return the noise of the maker's bound, which is so many standard deviations; the floor is the range's step."""
    model = LIDARS[name]
    return RangeNoise(
        model.near_accuracy / bound_sigmas,
        model.near_range,
        model.far_accuracy / bound_sigmas,
        model.resolution / np.sqrt(12.0),
    )


def noise_of_scan(
    bearings: FloatArray, ranges: FloatArray, reach: tuple[float, float], shared_error: float
) -> RangeNoise:
    """Estimate the noise from a scan: bearings in order and ranges (N,), of which those within ``reach`` are echoes.

    Neighbours do not show the error that they share, ``shared_error`` metres; it becomes the floor.
    """
    near, near_range, far = _noise_of_neighbours(bearings, ranges, reach)
    return RangeNoise(near, near_range, far, shared_error)


@compiled
def range_variance(r: float, noise: RangeNoise) -> float:
    """Square of ``RangeNoise.sigma`` at one range, m^2, for compiled code."""
    near, near_range, far, floor = noise
    slope = near if r <= near_range else far * r
    return slope * slope + floor * floor


@compiled
def _noise_of_neighbours(
    bearings: FloatArray, ranges: FloatArray, reach: tuple[float, float]
) -> tuple[float, float, float]:
    """Estimate near, near_range and far of RangeNoise from every three neighbouring echoes at equal steps.

    Along a straight wall 1/r is a sinusoid of the bearing, so the second difference u(-1) - 2 cos(step) u(0) + u(+1) of
    u = 1/r is noise alone, of variance 6 sigma^2 / r^4. Corners and gaps are the rarer the finer the scan; a median
    looks past them. The nearer and the farther half of the beams are asked apart: a noise that grows from one to the
    other is taken to grow with the range from half way on.
    """
    noise, r = np.empty(len(ranges)), np.empty(len(ranges))
    n = echoes = 0
    t_1 = t_0 = u_1 = u_0 = 0.0
    for j in range(len(ranges)):
        if not (reach[0] <= ranges[j] <= reach[1]):
            continue
        t, u = bearings[j], 1.0 / ranges[j]
        step, before = t - t_0, t_0 - t_1
        if echoes >= 2 and abs(step - before) < 0.1 * abs(step):
            r[n] = 1.0 / u_0
            noise[n] = abs(u_1 - 2.0 * np.cos(step) * u_0 + u) * r[n] * r[n] / np.sqrt(6.0)
            n += 1
        t_1, t_0, u_1, u_0 = t_0, t, u_0, u
        echoes += 1
    if n < 8:
        return UNKNOWN_NOISE, np.inf, 0.0
    noise, r = noise[:n], r[:n]
    middle = np.median(r)
    near = np.median(noise[r <= middle]) / NORMAL_MEDIAN
    far = np.median(noise[r >= middle]) / NORMAL_MEDIAN
    if far <= 1.2 * near:
        return max(near, far), np.inf, 0.0
    slope = far / np.median(r[r >= middle])
    return near, near / slope, slope
