"""A planar lidar in the simulated world: the Hokuyo URG-04LX, or any other ``LidarModel``."""

from __future__ import annotations

import numpy as np

from sim.range_noise import measure
from sim.world import World
from slam.pose import FloatArray, Pose2D
from slam.run.scenario.lidar_config import LidarConfig
from slam.scan import LaserScan


class Urg04lx:
    """Takes all beams of a scan at once, in a horizontal plane ``config.height`` metres above the floor."""

    def __init__(self, world: World, config: LidarConfig) -> None:
        model = config.description
        lidar = model.lidar
        self._world = world
        self._config = config
        self._lidar = lidar
        self._reach = float(lidar.range_max + model.accuracy(np.array(lidar.range_max)))  # noise may bring it nearer
        self._beams = self._reach * np.column_stack([np.cos(lidar.angles), np.sin(lidar.angles)])
        self._origins = np.full((lidar.beams, 3), config.height)
        self._ends = np.full((lidar.beams, 3), config.height)

    def scan(self, T_map_laser: Pose2D, stamp: float, rng: np.random.Generator) -> LaserScan:
        """What the lidar reports from there; the noise comes from ``rng``."""
        lidar = self._lidar
        return LaserScan(
            stamp=stamp,
            angle_min=lidar.angle_min,
            angle_increment=lidar.angle_increment,
            range_min=lidar.range_min,
            range_max=lidar.range_max,
            ranges=measure(self.true_ranges(T_map_laser), self._config, rng),
            scan_time=lidar.scan_time,
        )

    def true_ranges(self, T_map_laser: Pose2D) -> FloatArray:
        """Distance along each beam to what stands there, metres, shape (beams,); inf where nothing is in reach."""
        self._origins[:, :2] = T_map_laser.translation
        self._ends[:, :2] = T_map_laser.transform(self._beams)
        return self._reach * self._world.cast(self._origins, self._ends)
