"""The Estimator protocol of a run; dead reckoning; and the estimator of the settings."""

from typing import Protocol

from slam.config import HoppingConfig, SlamConfig
from slam.files.ros.decimals import rounded_pose
from slam.graph.closure import ClosedRun
from slam.graph.loop_closing import STEPPED, Timing
from slam.line_localizer import LineLocalizer, LocalizeThenMap
from slam.line_slam import Estimate, LineSlam
from slam.lines.range_noise import RangeNoise
from slam.mapping.line_map import LineMap
from slam.mapping.point_map import PointMap
from slam.matching.mapper import Lines, Points
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.saved_slam import SavedSlam, save
from slam.scan import LaserScan


class Estimator(Protocol):
    """Estimates the pose of the robot from scans and odometry."""

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


class DeadReckoning:
    """Wheel odometry alone, for comparison: it ignores scans, and makes no map."""

    def __init__(self, T_base_laser: Pose2D, T_map_base: Pose2D) -> None:
        self.T_base_laser = T_base_laser
        self.T_map_base = T_map_base
        self.points, self.lines = PointMap(), LineMap()
        self._last: Pose2D | None = None  # T_odom_base at the last scan

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        """Move by the odometry since the last scan."""
        if self._last is not None:
            self.T_map_base = self.T_map_base @ self._last.between(odometry.T_odom_base)
        self._last = odometry.T_odom_base
        return Estimate(scan.stamp, self.T_map_base)


def make_estimator(
    config: SlamConfig, T_base_laser: Pose2D, T_map_base: Pose2D, seed: int, timing: Timing = STEPPED
) -> Estimator:
    """Make the method of these settings, with the robot's base at its start.

    Both poses are rounded as a log has them. ``timing`` says when closures are applied.
    """
    T_base_laser, T_map_base = rounded_pose(T_base_laser), rounded_pose(T_map_base)
    if config.mode == "dead_reckoning":
        return DeadReckoning(T_base_laser, T_map_base)
    return LineSlam(config, T_base_laser, T_map_base, seed, timing)


def noise_learnt_by(estimator: Estimator) -> RangeNoise | None:
    """Return the learnt noise of the ranges after a run; None if the method does not learn it."""
    slam = _method_of(estimator)
    if not isinstance(slam, LineSlam | LineLocalizer) or isinstance(slam.config.lines, HoppingConfig):
        return None
    return slam.noise.noise


def finish(estimator: Estimator) -> ClosedRun | None:
    """End the run: return it with all its loops closed.

    None if the method closes none. BackEndLost if the back end has ended.
    """
    slam = _method_of(estimator)
    return slam.finish() if isinstance(slam, LineSlam) else None


def map_made_by(estimator: Estimator, closed: ClosedRun | None = None) -> SavedSlam | None:
    """Return the map to save after a run, which may be ``closed``; None if it has not changed, or in paper mode."""
    slam = _method_of(estimator)
    return save(slam, closed) if isinstance(slam, LineSlam) else None


def _method_of(estimator: Estimator) -> Estimator | None:
    """Return the estimator that maps; None for LocalizeThenMap before it maps."""
    return estimator.slam if isinstance(estimator, LocalizeThenMap) else estimator


_: tuple[type[Estimator], ...] = (LineLocalizer, LocalizeThenMap, DeadReckoning)
