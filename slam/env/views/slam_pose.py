"""``slam_pose``: where the method believes the robot is."""

from __future__ import annotations

from typing import Final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.env.step_state import StepState

_BOUND: Final = np.array([1e4, 1e4, np.pi], np.float32)
"""Of x, y (m), theta (rad)."""


class SlamPoseView:
    """x, y (m), theta (rad), map frame."""

    def space(self) -> Box:
        """Wide enough for any world."""
        return Box(-_BOUND, _BOUND, dtype=np.float32)

    def of(self, moment: StepState) -> NDArray[np.float32]:
        """The estimate of this moment."""
        return np.clip(moment.belief.as_array().astype(np.float32), -_BOUND, _BOUND)
