"""Wheel odometry alone, in the place of the method: what the others are compared with."""

from __future__ import annotations

from slam.line_slam import Estimate
from slam.mapping.line_map import LineMap
from slam.mapping.point_map import PointMap
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.scan import LaserScan


class DeadReckoning:
    """Looks at no scan and makes no map: the base is where the wheels say that it went from its start."""

    def __init__(self, T_base_laser: Pose2D, T_map_base: Pose2D) -> None:
        self.T_base_laser = T_base_laser
        self.T_map_base = T_map_base
        self.points, self.lines = PointMap(), LineMap()
        self._last: Pose2D | None = None  # T_odom_base with the last scan

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        """Move as the wheels did since the last scan."""
        if self._last is not None:
            self.T_map_base = self.T_map_base @ self._last.between(odometry.T_odom_base)
        self._last = odometry.T_odom_base
        return Estimate(scan.stamp, self.T_map_base)
