"""How a differential-drive base moves, and what its wheel encoders say of it: section 5, eqs. (38)-(44)."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, sin

import numpy as np

from slam.pose import Pose2D, wrap_angle


@dataclass(frozen=True, slots=True)
class Twist2D:
    """Velocity of the base in its own frame: metres a second forward, radians a second counter-clockwise."""

    linear: float = 0.0
    angular: float = 0.0

    @classmethod
    def from_wheels(cls, left: float, right: float, track: float) -> Twist2D:
        """The velocity of a base whose wheels, ``track`` metres apart, roll so many metres a second."""
        return cls((left + right) / 2.0, (right - left) / track)  # eqs. (39) and (38)

    @classmethod
    def from_motion(cls, motion: Pose2D, seconds: float) -> Twist2D:
        """The constant velocity that makes this motion, but for what slips sideways: the inverse of ``motion``.

        It is zero where no time passes.
        """
        if seconds <= 0.0:
            return cls()
        half = motion.theta / 2.0
        chord = motion.x * cos(half) + motion.y * sin(half)
        return cls(chord / float(np.sinc(half / np.pi)) / seconds, motion.theta / seconds)

    def wheels(self, track: float) -> tuple[float, float]:
        """Metres a second of the left and the right wheel, ``track`` metres apart."""
        rim = self.angular * track / 2.0
        return self.linear - rim, self.linear + rim

    def motion(self, seconds: float) -> Pose2D:
        """``T_base_moved`` after ``seconds`` at this velocity: the exact circular arc of eqs. (40)-(44).

        The paper divides by the turning angle beta and treats straight motion apart; written as a chord, length
        d sinc(beta/2) in direction beta/2, one formula holds for every beta, 0 included.
        """
        d, beta = self.linear * seconds, self.angular * seconds
        half = beta / 2.0
        chord = d * _sinc(half)  # eqs. (40) and (42) between them; eq. (44) at beta = 0
        return Pose2D(chord * cos(half), chord * sin(half), wrap_angle(beta))  # eqs. (41)-(44)


@dataclass(frozen=True, slots=True)
class Odometry:
    """Dead reckoning at ``stamp`` seconds: the base in the frame where the wheels were first read."""

    stamp: float
    T_odom_base: Pose2D
    twist: Twist2D = field(default_factory=Twist2D)


def _sinc(angle: float) -> float:
    """sin(angle) / angle, and its limit 1 at 0."""
    return sin(angle) / angle if abs(angle) > 1e-8 else 1.0


def wheel_motion(left: float, right: float, track: float) -> Pose2D:
    """``T_base_moved`` after the wheels, ``track`` metres apart, rolled ``left`` and ``right`` metres."""
    return Twist2D.from_wheels(left, right, track).motion(1.0)
