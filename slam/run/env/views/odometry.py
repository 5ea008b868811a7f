"""``odometry``: what the wheels say."""

from __future__ import annotations

from typing import Final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.odometry import Odometry
from slam.run.env.moment import Moment

_BOUND: Final = np.array([1e4, 1e4, np.pi, 10.0, 100.0], np.float32)
"""Of x, y (m), theta (rad), v (m/s), omega (rad/s): no robot of this kind goes beyond."""


class OdometryView:
    """x, y (m), theta (rad), v (m/s), omega (rad/s), from where the robot started."""

    def space(self) -> Box:
        """Wide enough for any robot of this kind."""
        return Box(-_BOUND, _BOUND, dtype=np.float32)

    def of(self, moment: Moment) -> NDArray[np.float32]:
        """The odometry of this moment."""
        return odometry_array(moment.observation.odometry)


def odometry_array(odometry: Odometry) -> NDArray[np.float32]:
    """Pose and twist in one array, shape (5,)."""
    pose, twist = odometry.T_odom_base, odometry.twist
    return np.clip(np.array([pose.x, pose.y, pose.theta, twist.linear, twist.angular], np.float32), -_BOUND, _BOUND)
