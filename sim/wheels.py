"""The wheels of the P3-DX: their size, their encoders, and the slip and scrub between them and the floor."""

from math import pi
from typing import Final, NamedTuple

from slam.scenario.robot_config import Traction

WHEEL_RADIUS: Final = 0.0975
"""Radius of the wheels in p3dx.urdf, metres."""
TICKS_PER_TURN: Final = 76_600
"""Encoder ticks a turn: 500 lines, read on 4 edges, behind a 38.3:1 gear; 125 ticks/mm, the vendor's table says 128."""
TICKS_PER_RADIAN: Final = TICKS_PER_TURN / (2.0 * pi)
TRACK: Final = 0.330
"""Distance between the wheels in p3dx.urdf, metres."""

Pair = tuple[float, float]
"""One value of the left wheel, one of the right."""


class Ticks(NamedTuple):
    """Both wheel encoders, counted from where the robot was put down; forward is positive."""

    left: int
    right: int


class TractionModel:
    """Slip and scrub scale the motion of the robot's wheels before it reaches the simulated ones, which have no error.

    The motors turn the robot's wheels, and the encoders count them. With slip s and scrub k = TRACK / effective_track,
    both the mean of the two simulated wheels is (1 - s) and their difference (1 - s) k times that of the robot's.
    """

    def __init__(self, traction: Traction) -> None:
        kept, scrub = 1.0 - traction.slip, TRACK / traction.effective_track
        self._same, self._other = kept * (1.0 + scrub) / 2.0, kept * (1.0 - scrub) / 2.0
        self._det = kept * kept * scrub

    def to_simulated(self, left: float, right: float) -> Pair:
        """Motion of the simulated wheels for this one of the robot's; angles or speeds."""
        return self._same * left + self._other * right, self._other * left + self._same * right

    def to_robot(self, left: float, right: float) -> Pair:
        """Motion of the robot's wheels for this one of the simulated: the inverse of ``to_simulated``."""
        a, b = self._same / self._det, self._other / self._det
        return a * left - b * right, a * right - b * left
