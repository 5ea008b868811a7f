"""The wheels of the P3-DX: their size, their encoders, slip and scrub on the floor, and dead reckoning.

The dead reckoning is that of the firmware, with its wrong beliefs and errors on purpose.
"""

from math import pi, sqrt
from typing import Final, NamedTuple

import numpy as np

from slam.odometry import Twist2D, wheel_motion
from slam.pose import Pose2D
from slam.scenario.robot_config import Traction, WheelErrors

WHEEL_RADIUS: Final = 0.0975
"""Radius of the wheels in p3dx.urdf, metres."""
TICKS_PER_TURN: Final = 76_600
"""Encoder ticks per turn: 500 lines, read on 4 edges, behind a 38.3:1 gear; 125 ticks/mm, the vendor's table says
128."""
TICKS_PER_RADIAN: Final = TICKS_PER_TURN / (2.0 * pi)
TRACK: Final = 0.330
"""Distance between the wheels in p3dx.urdf, metres."""
MILLIMETRE: Final = 1e-3
"""Unit of positions (m) and wheel speeds (m/s) in ARCOS: DistConvFactor and VelConvFactor of p3dx-sh.p."""
ANGLE_UNIT: Final = 2.0 * pi / 4096
"""Unit of headings in ARCOS, radians: AngleConvFactor of p3dx-sh.p."""

Pair = tuple[float, float]
"""A value for each wheel, left and right."""


class Ticks(NamedTuple):
    """Both wheel encoders, counted from the start; forward is positive."""

    left: int
    right: int


class TractionModel:
    """Slip and scrub scale the motion of the robot's wheels before it reaches the simulated ones, which have no error.

    The motors turn the robot's wheels, and the encoders count them. With slip s and scrub k = TRACK / effective_track,
    both the mean of the two simulated wheels is (1 - s) and their difference (1 - s) k times that of the robot's.
    """

    def __init__(self, traction: Traction) -> None:
        kept, scrub = 1.0 - traction.slip, TRACK / traction.effective_track
        self.same, self.other = kept * (1.0 + scrub) / 2.0, kept * (1.0 - scrub) / 2.0
        self._det = kept * kept * scrub

    def to_simulated(self, left: float, right: float) -> Pair:
        """Convert motion of the robot's wheels to that of the simulated ones; angles or speeds."""
        return self.same * left + self.other * right, self.other * left + self.same * right

    def to_robot(self, left: float, right: float) -> Pair:
        """Convert motion of the simulated wheels to that of the robot's: the inverse of ``to_simulated``."""
        a, b = self.same / self._det, self.other / self._det
        return a * left - b * right, a * right - b * left


class WheelOdometry:
    """Integrates ticks into ``T_odom_base``; the frame odom is the base where ``ticks`` were read."""

    def __init__(self, errors: WheelErrors, ticks: Ticks, rng: np.random.Generator) -> None:
        self._errors = errors
        self._rng = rng
        self._ticks = ticks
        self._T_odom_base = Pose2D()
        self._left = self._right = 0.0  # metres rolled since ``mean_twist``
        self._time = 0.0

    def add(self, ticks: Ticks) -> None:
        """Account for the motion since the last ticks."""
        if self._errors.encoder_noise:
            misread = self._errors.encoder_noise * self._rng.standard_normal(2)
            ticks = Ticks(ticks.left + round(misread[0]), ticks.right + round(misread[1]))
        left = self._travel(ticks.left - self._ticks.left, self._errors.left_radius)
        right = self._travel(ticks.right - self._ticks.right, self._errors.right_radius)
        self._T_odom_base = self._T_odom_base @ wheel_motion(left, right, self._errors.track)
        self._left += left
        self._right += right
        self._ticks = ticks

    @property
    def pose(self) -> Pose2D:
        """``T_odom_base`` as reported."""
        pose = self._T_odom_base
        if not self._errors.firmware_units:
            return pose
        return Pose2D(rounded(pose.x, MILLIMETRE), rounded(pose.y, MILLIMETRE), rounded(pose.theta, ANGLE_UNIT))

    def mean_twist(self, time: float) -> Twist2D:
        """Return the mean velocity since the last call, as reported at ``time`` seconds; 0 if no time passed."""
        rate = 1.0 / (time - self._time) if time > self._time else 0.0
        left, right = self._left * rate, self._right * rate
        if self._errors.firmware_units:
            left, right = rounded(left, MILLIMETRE), rounded(right, MILLIMETRE)
        self._left = self._right = 0.0
        self._time = time
        return Twist2D.from_wheels(left, right, self._errors.track)

    def _travel(self, ticks: int, radius: float) -> float:
        """Return the metres that a wheel with this assumed radius rolled.

        The error's variance grows with the distance.
        """
        distance = ticks * (2.0 * pi / TICKS_PER_TURN) * radius
        noise = self._errors.travel_noise
        return distance + noise * sqrt(abs(distance)) * self._rng.standard_normal() if noise else distance


def rounded(value: float, unit: float) -> float:
    """Round to whole units."""
    return round(value / unit) * unit
