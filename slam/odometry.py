"""Motion of a differential-drive base, and dead reckoning from its wheels: section 5, eqs. (38)-(44)."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, sin

import numpy as np

from slam.pose import Pose2D, wrap_angle


@dataclass(frozen=True, slots=True)
class Twist2D:
    """Velocity of the base in its own frame: m/s forward, rad/s counter-clockwise."""

    linear: float = 0.0
    angular: float = 0.0

    @classmethod
    def from_wheels(cls, left: float, right: float, track: float) -> Twist2D:
        """Return the velocity of a base whose wheels, ``track`` metres apart, roll at these speeds, m/s."""
        return cls((left + right) / 2.0, (right - left) / track)  # d = beta (R + W_r / 2), eq. (39), and beta, eq. (38)

    @classmethod
    def from_motion(cls, motion: Pose2D, seconds: float) -> Twist2D:
        """Return the constant velocity of this motion, ignoring sideways slip: the inverse of ``motion``.

        It is zero if no time passes.
        """
        if seconds <= 0.0:
            return cls()
        half = motion.theta / 2.0
        chord = motion.x * cos(half) + motion.y * sin(half)
        return cls(chord / float(np.sinc(half / np.pi)) / seconds, motion.theta / seconds)

    def to_wheels(self, track: float) -> tuple[float, float]:
        """Return the speeds of the left and the right wheel, ``track`` metres apart, m/s."""
        rim = self.angular * track / 2.0
        return self.linear - rim, self.linear + rim

    def motion(self, seconds: float) -> Pose2D:
        """``T_base_moved`` after ``seconds`` at this velocity: the exact circular arc of eqs. (40)-(44).

        The paper divides by the turning angle beta and treats straight motion separately; written as a chord, length d
        sinc(beta/2) in direction beta/2, one formula holds for every beta, including 0. Eq. (42) prints a minus before
        the radius R + W_r / 2; with the centre of eq. (40) it must be a plus, as here.
        """
        d, beta = self.linear * seconds, self.angular * seconds
        half = beta / 2.0
        chord = d * _sinc(half)  # eqs. (40) and (42) between them; eqs. (43), (44) at beta = 0
        return Pose2D(chord * cos(half), chord * sin(half), wrap_angle(beta))  # eqs. (41), (42), (44)


@dataclass(frozen=True, slots=True)
class Odometry:
    """Dead reckoning at ``stamp`` seconds: pose of the base in the frame where the wheels were first read."""

    stamp: float
    T_odom_base: Pose2D
    twist: Twist2D = field(default_factory=Twist2D)


def _sinc(angle: float) -> float:
    """Return sin(angle) / angle, with its limit 1 at 0."""
    return sin(angle) / angle if abs(angle) > 1e-8 else 1.0


def wheel_motion(left: float, right: float, track: float) -> Pose2D:
    """Return ``T_base_moved`` after the wheels, ``track`` metres apart, rolled ``left`` and ``right`` metres."""
    return Twist2D.from_wheels(left, right, track).motion(1.0)
