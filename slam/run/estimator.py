"""What a run asks of whoever estimates the pose: LineSlam, LineLocalizer, LineContinuation, DeadReckoning are such."""

from __future__ import annotations

from typing import Protocol

from slam.config import SlamConfig
from slam.line_localizer import LineLocalizer
from slam.line_slam import Estimate, LineSlam
from slam.localize_then_map import LocalizeThenMap
from slam.matching.mapper import Lines, Points
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.run.dead_reckoning import DeadReckoning
from slam.saved_slam import SavedSlam, save
from slam.scan import LaserScan


class Estimator(Protocol):
    """Takes scans and odometry, and says where the robot is."""

    T_base_laser: Pose2D

    @property
    def T_map_base(self) -> Pose2D: ...
    @property
    def points(self) -> Points: ...
    @property
    def lines(self) -> Lines: ...

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        """Take the next scan and the odometry at its stamp; return the pose estimate."""
        ...


def make_estimator(config: SlamConfig, T_base_laser: Pose2D, T_map_base: Pose2D, seed: int) -> Estimator:
    """The method of these settings, with the robot's base at its start."""
    if config.mode == "dead_reckoning":
        return DeadReckoning(T_base_laser, T_map_base)
    return LineSlam(config, T_base_laser, T_map_base, seed)


def map_made_by(estimator: Estimator) -> SavedSlam | None:
    """What is worth saving after a run: None where the map was not changed, or is the paper's."""
    slam = estimator.slam if isinstance(estimator, LocalizeThenMap) else estimator
    return save(slam) if isinstance(slam, LineSlam) else None


_: tuple[type[Estimator], ...] = (LineLocalizer, LocalizeThenMap, DeadReckoning)
