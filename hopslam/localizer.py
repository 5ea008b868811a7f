"""Localisation of a robot in a map that does not change."""

from math import inf
from pathlib import Path
from typing import Any

from hopslam.arguments import checked_lidar, checked_mount, checked_start
from hopslam.intake import Intake
from hopslam.line_map import Map, state_of
from hopslam.scan import RANGE_MIN
from hopslam.segments import Segments
from hopslam.settings import SettingsLike, slam_config
from hopslam.slam import Estimate
from slam.line_localizer import LineLocalizer
from slam.pose import Pose2D


class Localizer:
    """Localises a robot in a saved map (a Map or its path). Keep driving the robot until ``sure`` is True.

    With ``start``, the pose x, y, theta of the robot at its first scan, it is sure from there on. The other arguments
    are those of Slam. ``Estimate.lost`` is True while it is not sure; the covariance is relative to the map.
    """

    def __init__(
        self,
        saved_map: Map | str | Path,
        settings: SettingsLike = (),
        *,
        T_base_laser: Any = (0.0, 0.0, 0.0),
        start: Any = None,
        range_min: float = RANGE_MIN,
        range_max: float = inf,
        time_increment: float = 0.0,
    ) -> None:
        self._config = slam_config(settings)
        self._saved = state_of(saved_map, self._config)
        self._T_base_laser = checked_mount("T_base_laser", T_base_laser)
        self._start = None if start is None else checked_start("start", start)
        self._intake = Intake(checked_lidar(range_min, range_max, time_increment))
        self._method: LineLocalizer | None = None  # set at the first scan, which shows whether there is odometry

    @property
    def sure(self) -> bool:
        """True while the place of the robot is known."""
        return self._start is not None if self._method is None else self._method.sure

    @property
    def pose(self) -> Pose2D:
        """Most likely pose of the robot; the origin before the first hypothesis."""
        return self._start or Pose2D() if self._method is None else self._method.T_map_base

    def update(self, ranges: Any, angles: Any = None, odometry: Any = None, stamp: float | None = None) -> Estimate:
        """Take the next scan, as ``Slam.update`` does; return the estimate after it."""
        scan, moved, measured = self._intake.take(ranges, angles, odometry, stamp)
        if self._method is None:
            config = self._config if measured else self._config.without_odometry()
            surfels, noise = self._saved.mapper.map, self._saved.noise
            self._method = LineLocalizer(config, self._T_base_laser, surfels, self._start, noise)
        found = self._method.update(scan, moved)
        segments = None if found.segments is None else Segments(found.segments, scan.points())
        return Estimate(found.stamp, found.T_map_base, found.covariance, found.lost, False, segments)
