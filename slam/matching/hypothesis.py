"""One answer to the question where the robot is, and how well the scans bear it out."""

from __future__ import annotations

import numpy as np

from slam.config import LeastSquaresConfig, LocalizationConfig
from slam.lines.segments import Segments
from slam.mapping.drift import Drift
from slam.mapping.free_space import count_seen_through, free_beams
from slam.mapping.surfel_map import SurfelMap
from slam.matching.match import NO_MATCH, Match
from slam.matching.surfel_mapper import SurfelMapper
from slam.matching.surfel_memory import SurfelMemory
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

SAME = 0.3, 0.15
"""Hypotheses nearer than this, metres and radians, are one."""
AT_FIRST = np.diag([0.1**2, 0.1**2, 0.05**2])
"""Covariance of a place that was found by search."""


class Hypothesis:
    """Tracks one pose in a map that does not change; without ``odometry`` each scan may be anywhere near the last."""

    def __init__(
        self,
        surfel_map: SurfelMap,
        config: LeastSquaresConfig,
        T_base_laser: Pose2D,
        T_map_base: Pose2D,
        odometry: bool = True,
    ):
        self.T_map_base = T_map_base
        self.match: Match = NO_MATCH
        self.evidence = 0.0  # sum of the agreements, from where the best of its time stood when it was begun
        self.average = 1.0
        self._T_base_laser, self._odometry = T_base_laser, odometry
        memory = SurfelMemory(surfel_map, Drift(), T_map_base, None, AT_FIRST)
        self._mapper = SurfelMapper(memory, config, T_base_laser, odometry)
        self._map = surfel_map

    @property
    def covariance(self) -> FloatArray:
        """Of x, y, theta of ``T_map_base`` against the map, (3, 3), metres and radians."""
        return self._mapper.memory.covariance

    def follow(self, scan: LaserScan, segments: Segments, motion: Pose2D) -> None:
        """Move as the odometry says, and match."""
        prior = self.T_map_base @ motion
        self.match = self._mapper.locate(scan, segments, prior)
        T_map_laser = prior @ self._T_base_laser @ self.match.T_prior_laser
        self.T_map_base = T_map_laser @ self._T_base_laser.inverse()

    def track(self, config: LeastSquaresConfig) -> None:
        """Go on with other settings of the matcher."""
        if self._mapper.config is not config:
            self._mapper = SurfelMapper(self._mapper.memory, config, self._T_base_laser, self._odometry)

    def agreement(self, scan: LaserScan, config: LocalizationConfig) -> float:
        """Of the scan that was followed last: 1 where all of it lies on walls, and none was seen through."""
        pose, settings = (self.T_map_base @ self._T_base_laser).as_array(), self._map.config
        beams = free_beams(scan, settings.no_echo_reach)
        through = count_seen_through(self._map.grid, beams, pose, settings.carve_reach, settings.free_margin)
        return (self.match.inliers - config.seen_through * through) / max(self.match.points, 1)

    def learn(self, agreement: float, memory: float) -> None:
        """Take an agreement into the sum and the average."""
        self.evidence += agreement
        self.average = memory * self.average + (1.0 - memory) * agreement

    def same_as(self, other: Hypothesis) -> bool:
        """Whether the two have come together."""
        return near(self.T_map_base, other.T_map_base)


def near(a: Pose2D, b: Pose2D) -> bool:
    """Whether two poses are one hypothesis."""
    return a.distance(b) < SAME[0] and abs(a.between(b).theta) < SAME[1]
