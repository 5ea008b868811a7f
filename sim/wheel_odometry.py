"""Dead reckoning from wheel encoders, with a wrong calibration and random slip on purpose."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from sim.p3dx import TICKS_PER_TURN, Ticks
from slam.odometry import Odometry, Twist2D, wheel_motion
from slam.pose import Pose2D
from slam.run.scenario.robot_config import WheelErrors


class WheelOdometry:
    """Integrates ticks into ``T_odom_base``; the frame odom is the base where ``ticks`` were read."""

    def __init__(self, errors: WheelErrors, ticks: Ticks, rng: np.random.Generator) -> None:
        self._errors = errors
        self._rng = rng
        self._ticks = ticks
        self._T_odom_base = Pose2D()
        self._left = self._right = 0.0  # metres rolled since ``read``
        self._stamp = 0.0

    def add(self, ticks: Ticks) -> None:
        """Account for the motion since the last ticks."""
        left = self._travel(ticks.left - self._ticks.left, self._errors.left_radius)
        right = self._travel(ticks.right - self._ticks.right, self._errors.right_radius)
        self._T_odom_base = self._T_odom_base @ wheel_motion(left, right, self._errors.track)
        self._left += left
        self._right += right
        self._ticks = ticks

    def read(self, stamp: float) -> Odometry:
        """The odometry at ``stamp`` seconds; its twist is the mean since the last reading."""
        seconds = stamp - self._stamp
        twist = Twist2D(
            (self._left + self._right) / 2.0 / seconds, (self._right - self._left) / self._errors.track / seconds
        )
        self._left = self._right = 0.0
        self._stamp = stamp
        return Odometry(stamp, self._T_odom_base, twist)

    def _travel(self, ticks: int, radius: float) -> float:
        """Metres that a wheel believed of this radius rolled; the variance of the error grows with the way."""
        way = ticks * (2.0 * pi / TICKS_PER_TURN) * radius
        noise = self._errors.travel_noise
        return way + noise * sqrt(abs(way)) * self._rng.standard_normal() if noise else way
