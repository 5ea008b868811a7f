"""A hypothesis of the robot's pose, with its evidence from the scans."""

from __future__ import annotations

import numpy as np

from slam.config import LeastSquaresConfig, LocalizationConfig
from slam.lines.segments import Segments
from slam.mapping.free_beams import free_beams
from slam.mapping.free_space import count_seen_through
from slam.mapping.map_uncertainty import MapUncertainty
from slam.mapping.surfel_map import SurfelMap
from slam.matching.match import NO_MATCH, Match
from slam.matching.surfel_mapper import SurfelMapper
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

SAME_DISTANCE, SAME_ANGLE = 0.3, 0.15
"""Hypotheses nearer than this, metres and radians, count as one."""
FOUND_COVARIANCE = np.diag([0.1**2, 0.1**2, 0.05**2])
"""Covariance of a pose from the search."""


class PoseHypothesis:
    """Tracks one pose in a map that does not change; without ``odometry`` the motion between scans is unknown."""

    def __init__(
        self,
        surfel_map: SurfelMap,
        config: LeastSquaresConfig,
        T_base_laser: Pose2D,
        T_map_base: Pose2D,
        odometry: bool,
    ) -> None:
        self.T_map_base = T_map_base
        self.match: Match = NO_MATCH
        self.evidence = 0.0  # sum of the agreements; a late hypothesis starts with the sum of the best one
        self.mean_agreement = 1.0  # a running mean
        self._T_base_laser, self._odometry = T_base_laser, odometry
        state = SurfelMapperState(surfel_map, MapUncertainty(), T_map_base, None, FOUND_COVARIANCE)
        self._mapper = SurfelMapper(state, config, T_base_laser, odometry)

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of ``T_map_base`` against the map, metres and radians."""
        return self._mapper.state.covariance

    def follow(self, scan: LaserScan, segments: Segments, motion: Pose2D) -> None:
        """Move by the odometry, and match."""
        prior = self.T_map_base @ motion
        self.match = self._mapper.locate(scan, segments, prior)
        T_map_laser = prior @ self._T_base_laser @ self.match.T_prior_laser
        self.T_map_base = T_map_laser @ self._T_base_laser.inverse()

    def reconfigure(self, config: LeastSquaresConfig) -> None:
        """Continue with other settings of the matcher."""
        if self._mapper.config is not config:
            self._mapper = SurfelMapper(self._mapper.state, config, self._T_base_laser, self._odometry)

    def agreement(self, scan: LaserScan, config: LocalizationConfig) -> float:
        """Agreement of the last scan with the map: 1 if all of it lies on walls, and no beam went through one."""
        pose, surfel_map = (self.T_map_base @ self._T_base_laser).as_array(), self._mapper.map
        settings = surfel_map.config
        beams = free_beams(scan, settings.no_echo_reach)
        through = count_seen_through(surfel_map.grid, beams, pose, settings.carve_reach, settings.free_margin)
        return (self.match.inliers - config.seen_through * through) / max(self.match.points, 1)

    def add_agreement(self, agreement: float, memory: float) -> None:
        """Add an agreement to the evidence and to the running mean, whose past has the weight ``memory``."""
        self.evidence += agreement
        self.mean_agreement = memory * self.mean_agreement + (1.0 - memory) * agreement

    def same_place(self, other: PoseHypothesis) -> bool:
        """Return True if the two are so near each other that they count as one."""
        a, b = self.T_map_base, other.T_map_base
        return a.distance(b) < SAME_DISTANCE and abs(a.between(b).theta) < SAME_ANGLE
