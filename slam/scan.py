"""One turn of a planar lidar, with the field names of ``sensor_msgs/LaserScan``."""

from dataclasses import dataclass
from functools import lru_cache
from sys import float_info

import numpy as np
from numpy.typing import NDArray

from slam.lidars import Lidar
from slam.pose import FloatArray, unit_vectors

BEARING, COS, SIN = range(3)
"""Rows of a fan (3, N): the bearing of each beam, its cosine and its sine."""


@lru_cache(maxsize=64)
def even_fan(angle_min: float, angle_increment: float, beams: int) -> FloatArray:
    """Return the fan (3, N) of evenly spaced beams; must not be written to."""
    angles = angle_min + angle_increment * np.arange(beams, dtype=np.float64)
    return np.stack([angles, np.cos(angles), np.sin(angles)])


@dataclass(frozen=True, slots=True, eq=False)
class LaserScan:
    """One scan in the sensor frame (x forward, y left); beam ``j`` points at ``angle_min + j * angle_increment``.

    ``ranges`` has shape (N,), in metres; following REP-117, ``inf`` means no echo, ``-inf`` too close and ``nan`` an
    erroneous reading. ``stamp`` is the time of the first beam in seconds; ``time_increment`` the time between two beams
    (0 when they are taken at once).
    """

    stamp: float
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: FloatArray
    time_increment: float = 0.0
    scan_time: float = 0.1
    beam_fan: FloatArray | None = None
    """The fan (3, N) of a deskewed scan; None if the beams are evenly spaced."""

    @property
    def angle_max(self) -> float:
        """Bearing of the last beam."""
        return self.lidar.angle_max

    @property
    def fan(self) -> FloatArray:
        """Bearings of all beams in the sensor frame, their cosines and sines, shape (3, N); must not be written to."""
        if self.beam_fan is None:
            return even_fan(self.angle_min, self.angle_increment, len(self.ranges))
        return self.beam_fan

    @property
    def bearings(self) -> FloatArray:
        """Bearings of all beams in the sensor frame, shape (N,), radians."""
        return self.lidar.angles if self.beam_fan is None else self.beam_fan[BEARING]

    def __eq__(self, other: object) -> bool:
        """Compare bit by bit; two ``nan`` readings are equal."""
        if not isinstance(other, LaserScan):
            return NotImplemented
        same = (self.stamp, self.lidar, self.time_increment) == (other.stamp, other.lidar, other.time_increment)
        same = same and np.array_equal(self.bearings, other.bearings)
        return same and np.array_equal(self.ranges, other.ranges, equal_nan=True)

    __hash__ = None  # type: ignore[assignment]  # holds an array

    @property
    def lidar(self) -> Lidar:
        """The sensor that took this scan."""
        return Lidar(
            self.angle_min, self.angle_increment, len(self.ranges), self.range_min, self.range_max, self.scan_time
        )

    @property
    def reach(self) -> tuple[float, float]:
        """Least and greatest range of an echo, metres; both are finite, so that ``inf`` is outside."""
        return self.range_min, min(self.range_max, float_info.max)

    @property
    def echoes(self) -> NDArray[np.bool_]:
        """True for each beam with an echo within the sensor's range limits, shape (N,)."""
        return np.isfinite(self.ranges) & (self.ranges >= self.range_min) & (self.ranges <= self.range_max)

    def points(self) -> FloatArray:
        """Return end points of the beams with an echo, in beam order, shape (M, 2), sensor frame: eq. (1)."""
        echoes = self.echoes
        d, theta = self.ranges[echoes], self.bearings[echoes]
        return d[:, None] * unit_vectors(theta)  # eq. (1)
