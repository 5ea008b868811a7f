"""How a differential-drive base moves, and what its wheel encoders say of it: section 5, eqs. (38)-(44)."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, sin

from slam.pose import Pose2D, wrap_angle


@dataclass(frozen=True, slots=True)
class Twist2D:
    """Velocity of the base in its own frame: metres a second forward, radians a second counter-clockwise."""

    linear: float = 0.0
    angular: float = 0.0

    def motion(self, seconds: float) -> Pose2D:
        """How far one gets at this speed, ``T_base_moved``."""
        way, turn = self.linear * seconds, self.angular * seconds
        return wheel_motion(way - turn / 2.0, way + turn / 2.0, 1.0)


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
    """The motion ``T_base_moved`` after the wheels rolled ``left`` and ``right`` metres, ``track`` metres apart.

    The exact circular arc of eqs. (38)-(44). The paper divides by the turning angle beta and treats straight motion
    apart; written as a chord, length d sinc(beta/2) in direction beta/2, one formula holds for every beta, 0 included.
    Eq. (42) prints a minus before the radius R + W_r / 2; with the centre of eq. (40) it must be a plus, as here.
    """
    beta = (right - left) / track  # eq. (38)
    d = (left + right) / 2.0  # = beta (R + W_r / 2), eq. (39)
    chord = d * _sinc(beta / 2.0)  # eqs. (40) and (42) between them; eqs. (43), (44) at beta = 0
    return Pose2D(chord * cos(beta / 2.0), chord * sin(beta / 2.0), wrap_angle(beta))  # eqs. (41), (42), (44)
