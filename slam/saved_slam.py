"""The method put aside, to go on later where it stopped or from another place in the same map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slam.config import LeastSquaresConfig, SlamConfig
from slam.line_slam import LineSlam
from slam.matching.surfel_mapper import SurfelMapper
from slam.matching.surfel_memory import SurfelMemory
from slam.pose import Pose2D

SET_DOWN = np.diag([0.05**2, 0.05**2, 0.05**2])
"""How well a robot is set down where it is said to be: covariance of x, y, theta, metres and radians."""


@dataclass(frozen=True, slots=True, eq=False)
class SavedSlam:
    """What LineSlam knows with this project's matcher and map; the arrays are shared with it."""

    memory: SurfelMemory
    T_map_base: Pose2D
    """The last estimate ..."""
    T_odom_base: Pose2D | None
    """... and the odometry with it; None before the first scan."""
    T_map_mapped: Pose2D | None
    """The last estimate whose scan was matched."""


def save(slam: LineSlam) -> SavedSlam | None:
    """What ``resume`` needs; None where the map is not this project's own, and is not saved."""
    if not isinstance(slam.mapper, SurfelMapper):
        return None
    return SavedSlam(slam.mapper.memory, slam.T_map_base, slam.last_odometry, slam.last_mapped)


def resume(config: SlamConfig, T_base_laser: Pose2D, saved: SavedSlam) -> LineSlam:
    """The method as if it had never stopped: the next scan and its odometry continue the same run."""
    slam = LineSlam(config, T_base_laser, saved.T_map_base)
    slam.mapper = _mapper(config, T_base_laser, saved.memory)
    slam.last_odometry, slam.last_mapped = saved.T_odom_base, saved.T_map_mapped
    return slam


def relocate(config: SlamConfig, T_base_laser: Pose2D, saved: SavedSlam, T_map_base: Pose2D) -> LineSlam:
    """The method in the saved map with a robot that begins anew there, its odometry too."""
    slam = LineSlam(config, T_base_laser, T_map_base)
    slam.mapper = _mapper(config, T_base_laser, saved.memory.standing(T_map_base, SET_DOWN))
    return slam


def _mapper(config: SlamConfig, T_base_laser: Pose2D, memory: SurfelMemory) -> SurfelMapper:
    assert isinstance(config.matching, LeastSquaresConfig)
    return SurfelMapper(memory, config.matching, T_base_laser, config.odometry)
