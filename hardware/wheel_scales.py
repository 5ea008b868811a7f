"""What the robot reports of its wheels, put right: the factors that ``hopslam calibrate`` finds."""

from __future__ import annotations

from dataclasses import dataclass

from slam.odometry import Twist2D


@dataclass(frozen=True, slots=True)
class WheelScales:
    """Of the left and the right wheel's way, and of the track, whose half the robot believes to be ``half_track``."""

    half_track: float
    left: float = 1.0
    right: float = 1.0
    track: float = 1.0

    def corrected(self, motion: Twist2D) -> Twist2D:
        """A speed, or a short way and turn, as it really is."""
        track = 2.0 * self.half_track
        left, right = motion.wheels(track)
        return Twist2D.from_wheels(self.left * left, self.right * right, track * self.track)
