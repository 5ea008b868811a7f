"""Dead reckoning from wheel encoders as the firmware does it, with its wrong beliefs and errors on purpose."""

from math import pi, sqrt
from typing import Final

import numpy as np

from sim.wheels import TICKS_PER_TURN, Ticks
from slam.odometry import Twist2D, wheel_motion
from slam.pose import Pose2D
from slam.scenario.robot_config import WheelErrors

MILLIMETRE: Final = 1e-3
"""Unit of positions (m) and wheel speeds (m/s) in ARCOS: DistConvFactor and VelConvFactor of p3dx-sh.p."""
ANGLE_UNIT: Final = 2.0 * pi / 4096
"""Unit of headings in ARCOS, radians: AngleConvFactor of p3dx-sh.p."""


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
        ticks = self._misread(ticks) if self._errors.encoder_noise else ticks
        left = self._travel(ticks.left - self._ticks.left, self._errors.left_radius)
        right = self._travel(ticks.right - self._ticks.right, self._errors.right_radius)
        self._T_odom_base = self._T_odom_base @ wheel_motion(left, right, self._errors.track)
        self._left += left
        self._right += right
        self._ticks = ticks

    @property
    def pose(self) -> Pose2D:
        """``T_odom_base`` as it is reported."""
        pose = self._T_odom_base
        if not self._errors.firmware_units:
            return pose
        return Pose2D(rounded(pose.x, MILLIMETRE), rounded(pose.y, MILLIMETRE), rounded(pose.theta, ANGLE_UNIT))

    def mean_twist(self, time: float) -> Twist2D:
        """Mean velocity since the last call, as it is reported at ``time`` seconds; 0 where no time passed."""
        rate = 1.0 / (time - self._time) if time > self._time else 0.0
        left, right = self._left * rate, self._right * rate
        if self._errors.firmware_units:
            left, right = rounded(left, MILLIMETRE), rounded(right, MILLIMETRE)
        self._left = self._right = 0.0
        self._time = time
        return Twist2D.from_wheels(left, right, self._errors.track)

    def _misread(self, ticks: Ticks) -> Ticks:
        left, right = self._errors.encoder_noise * self._rng.standard_normal(2)
        return Ticks(ticks.left + round(left), ticks.right + round(right))

    def _travel(self, ticks: int, radius: float) -> float:
        """Metres that a wheel believed of this radius rolled; the variance of the error grows with the way."""
        way = ticks * (2.0 * pi / TICKS_PER_TURN) * radius
        noise = self._errors.travel_noise
        return way + noise * sqrt(abs(way)) * self._rng.standard_normal() if noise else way


def rounded(value: float, unit: float) -> float:
    """Round to whole units."""
    return round(value / unit) * unit
