"""``odometry``: what the wheels say."""

from __future__ import annotations

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.env.step_state import StepState
from slam.run.arrays import odometry_array, odometry_space


class OdometryView:
    """x, y (m), theta (rad), v (m/s), omega (rad/s), from where the robot started."""

    def space(self) -> Box:
        """Wide enough for any robot of this kind."""
        return odometry_space()

    def of(self, moment: StepState) -> NDArray[np.float32]:
        """The odometry of this moment."""
        return odometry_array(moment.observation.odometry)
