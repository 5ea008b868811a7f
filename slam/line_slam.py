"""The whole method on one page: Fig. 14."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from slam.config import SlamConfig
from slam.lines.extraction import extract_segments
from slam.lines.segments import Segments
from slam.mapping.line_map import LineMap
from slam.mapping.point_map import PointMap
from slam.matching.force_field import NO_MATCH, Match, match_points_to_segments
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """Where the robot is after one scan, and how that was found."""

    stamp: float
    T_map_base: Pose2D
    segments: Segments | None = None
    """In the sensor frame; None when the scan was not used and the pose is odometry since the last one that was."""
    match: Match = NO_MATCH
    extraction_time: float = 0.0
    """Seconds of wall time for the extraction of the segments ..."""
    total_time: float = 0.0
    """... and for all of the update."""

    @property
    def mapped(self) -> bool:
        """Whether the scan went into the map."""
        return self.segments is not None


class LineSlam:
    """Localisation by matching map points to the line segments of the present scan, and the map that this makes."""

    def __init__(self, config: SlamConfig, T_base_laser: Pose2D, T_map_base: Pose2D | None = None, seed: int = 0):
        self.config = config
        self.T_base_laser = T_base_laser
        self.T_map_base = T_map_base or Pose2D()  # the anchor: at the first scan the estimate is the truth (section 4)
        self.points = PointMap()
        self.lines = LineMap()
        self._random = np.random.default_rng(seed)
        self._last_odometry: Pose2D | None = None
        self._last_mapped: Pose2D | None = None

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        """Take the next scan and the odometry at its stamp; return the new pose estimate. One turn of Fig. 14."""
        began = perf_counter()
        prior = self._predict(odometry)  # eqs. (38)-(44)
        if not self._moved_enough(prior):
            self.T_map_base = prior
            return Estimate(scan.stamp, prior, total_time=perf_counter() - began)
        segments = extract_segments(scan, self.config.lines)  # eqs. (1)-(12), Proc. 1-8
        extracted = perf_counter()
        T_map_laser = prior @ self.T_base_laser
        visible = self.points.draw_visible(T_map_laser, scan.lidar, self.config.map, self._random)  # eq. (20)
        match = match_points_to_segments(visible, segments, self.config.matching)  # eqs. (21)-(37)
        T_map_laser = T_map_laser @ match.T_prior_laser  # eq. (19)
        self.points.add(scan.points(), T_map_laser)  # eqs. (15)-(18)
        self.lines.add(segments, T_map_laser)
        self.T_map_base = self._last_mapped = T_map_laser @ self.T_base_laser.inverse()
        return Estimate(scan.stamp, self.T_map_base, segments, match, extracted - began, perf_counter() - began)

    def _predict(self, odometry: Odometry) -> Pose2D:
        """Where the base is before the scan is looked at: moved as the wheels say, or still where it was."""
        last, self._last_odometry = self._last_odometry, odometry.T_odom_base
        if last is None or not self.config.odometry:
            return self.T_map_base
        return self.T_map_base @ last.between(odometry.T_odom_base)

    def _moved_enough(self, prior: Pose2D) -> bool:
        if self._last_mapped is None:
            return True
        motion = self._last_mapped.between(prior)
        return motion.distance(Pose2D()) >= self.config.update_distance or abs(motion.theta) >= self.config.update_angle
