"""``goal``: the next way-point, as seen from the robot."""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.env.step_state import StepState

_REACH: Final = 2e4
"""No way-point is farther, metres."""


class GoalView:
    """Distance (m) and bearing (rad), or x ahead and y to the left (m), from the true pose, as if a beacon stood there.

    Zeros when no way-point is left.
    """

    def __init__(self, form: Literal["polar", "xy"]) -> None:
        self._form = form

    def space(self) -> Box:
        """Distance and bearing, or two coordinates."""
        high = np.array([_REACH, np.pi if self._form == "polar" else _REACH], np.float32)
        low = np.array([0.0 if self._form == "polar" else -_REACH, -high[1]], np.float32)
        return Box(low, high, dtype=np.float32)

    def of(self, moment: StepState) -> NDArray[np.float32]:
        """The next way-point from where the robot is at this moment."""
        if moment.goal is None:
            return np.zeros(2, np.float32)
        base = moment.T_map_base
        if self._form == "polar":
            return np.array([base.distance(moment.goal), base.bearing(moment.goal)], np.float32)
        relative = base.between(moment.goal)
        return np.array([relative.x, relative.y], np.float32)
