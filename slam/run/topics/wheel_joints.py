"""Angles of the wheels, computed back from the odometry."""

from typing import Final

import numpy as np

from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scenario.robot_config import WheelErrors

WHEEL_JOINTS: Final = "left_wheel", "right_wheel"
"""Joints of p3dx.urdf."""


class WheelJoints:
    """Angles of both wheels, from the odometry.

    The firmware computes odometry from the angles that its encoders measure, with the radii and the track in its
    settings. With the same radii and track, the angles are recovered here, except for the firmware's rounding.
    """

    def __init__(self, wheels: WheelErrors) -> None:
        self._radii, self._track = np.array([wheels.left_radius, wheels.right_radius]), wheels.track
        self._last: Pose2D | None = None
        self.angles: FloatArray = np.zeros(2)
        """Angles of left and right wheel, radians; 0 at the first odometry."""
        self.speeds: FloatArray = np.zeros(2)
        """Speeds of left and right wheel, rad/s."""

    def add(self, odometry: Odometry) -> None:
        """Process the next odometry."""
        if self._last is not None:
            motion = Twist2D.from_motion(self._last.between(odometry.T_odom_base), 1.0)
            self.angles = self.angles + np.array(motion.to_wheels(self._track)) / self._radii
        self._last = odometry.T_odom_base
        self.speeds = np.array(odometry.twist.to_wheels(self._track)) / self._radii
