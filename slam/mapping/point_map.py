"""The map of points: section 4.1."""

import numpy as np
from numpy.typing import NDArray

from slam.config import PointMapConfig
from slam.lidars import Lidar
from slam.pose import FloatArray, Pose2D


class PointMap:
    """W_k of eq. (18): every point of every scan, in the map frame. As in the paper, it grows with the run."""

    def __init__(self) -> None:
        self._store = np.empty((1024, 2))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def points(self) -> FloatArray:
        """All points so far, shape (N_map, 2), metres; a view that must not be written to."""
        return self._store[: self._count]

    def add(self, points: FloatArray, T_map_laser: Pose2D) -> None:
        """Append a scan's points (N, 2), given in the sensor frame: W_k = [W_{k-1} V_k], eqs. (15)-(18)."""
        count = self._count + len(points)
        if count > len(self._store):
            store = np.empty((max(count, 2 * len(self._store)), 2))
            store[: self._count] = self.points
            self._store = store
        self._store[self._count : count] = T_map_laser.transform(points)  # V_k: eqs. (15) and (17)
        self._count = count

    def draw_visible(
        self, T_map_laser: Pose2D, lidar: Lidar, config: PointMapConfig, random: np.random.Generator
    ) -> FloatArray:
        """Draw a random share of the points that ``lidar`` could see from there, in the sensor frame, shape (N*, 2).

        w* of eq. (20), within the range of the sensor, and thinned as in section 5.1 (75 %).
        """
        reach = min(lidar.range_max, config.reach)
        near = self.points[np.abs(self.points - T_map_laser.translation).max(axis=1, initial=0.0) <= reach]
        local = T_map_laser.inverse().transform(near)  # eq. (20)
        local = local[_visible(local, lidar, reach)]
        return local[random.random(len(local)) < config.draw]


def _visible(points: FloatArray, lidar: Lidar, reach: float) -> NDArray[np.bool_]:
    """Return True for each point (N, 2), sensor frame, in the fan of the lidar and no farther than ``reach`` metres."""
    distance = np.hypot(points[:, 0], points[:, 1])
    bearing = np.arctan2(points[:, 1], points[:, 0])
    in_fan = (bearing - lidar.angle_min) % (2 * np.pi) <= lidar.angle_max - lidar.angle_min
    return in_fan & (distance >= lidar.range_min) & (distance <= reach)
