"""Between the wheels and the floor: slip and scrub, applied where the simulated wheels touch it."""

from __future__ import annotations

from typing import Final

from slam.scenario.robot_config import Traction

TRACK: Final = 0.330
"""Between the wheels in p3dx.urdf, metres."""

Pair = tuple[float, float]
"""Of the left and of the right wheel."""


class TractionModel:
    """The simulated wheels roll without any error, so they turn as little as the floor makes of the robot's own.

    With slip s and scrub k = TRACK / effective_track, both the mean of the two wheels is (1 - s) and their difference
    (1 - s) k times that of the robot's wheels, which the motors turn and the encoders count.
    """

    def __init__(self, traction: Traction) -> None:
        kept, scrub = 1.0 - traction.slip, TRACK / traction.effective_track
        self._same, self._other = kept * (1.0 + scrub) / 2.0, kept * (1.0 - scrub) / 2.0
        self._det = kept * kept * scrub

    def rolled(self, left: float, right: float) -> Pair:
        """What the simulated wheels do when the robot's turn like this; angles or speeds."""
        return self._same * left + self._other * right, self._other * left + self._same * right

    def turned(self, left: float, right: float) -> Pair:
        """What the robot's wheels did when the simulated ones rolled like this: the inverse."""
        a, b = self._same / self._det, self._other / self._det
        return a * left - b * right, a * right - b * left
