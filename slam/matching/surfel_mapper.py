"""This project's matcher and map: the facets of a scan are matched to surfels, with odometry as a prior."""

from dataclasses import replace
from typing import Any

import numpy as np

from slam.config import LeastSquaresConfig, SearchConfig
from slam.lines.facets import facets_of
from slam.lines.range_noise import RangeNoise
from slam.lines.segments import Segments
from slam.mapping.surfel_map import SurfelMap
from slam.matching.least_squares import SolverSettings, fuse
from slam.matching.match import Match
from slam.matching.pose_search import Found, PoseSearch, Scene, pose_offset
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.matching.wall_heading import WallHeading
from slam.motion_model import excess_covariance, motion_covariance, propagate, updated_excess
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

STANDING_LENGTH = 1.0  # metres and radians of the sensor until a small thing counts as standing: legs do not
KERNEL_SIGMAS, FLOOR_SIGMAS = 2.0, 0.6  # lower bounds of kernel and floor, in standard deviations of a near range
UNSUPPORTED = 0.1  # least share of agreeing facets: below it a scan is rejected


class SurfelMapper:
    """Robust least squares on the facets of a scan and the surfels of the map."""

    def __init__(
        self, state: SurfelMapperState, config: LeastSquaresConfig, T_base_laser: Pose2D, odometry: bool = True
    ) -> None:
        self.state = state
        self.config, self.T_base_laser, self._odometry = config, T_base_laser, odometry
        self._settings = _solver_settings(config, odometry)
        self._facets = np.empty((0, 7))
        self._walls = WallHeading(state.directions, config.directions == "auto")
        self._search = PoseSearch(_search_config(config.search, odometry), state.map.config.carve_reach, self._walls)
        self._found: Found | None = None  # for the last scan

    @property
    def map(self) -> SurfelMap:
        """The map that scans are matched to."""
        return self.state.map

    @property
    def points(self) -> SurfelMap:
        """The map as points."""
        return self.state.map

    @property
    def lines(self) -> SurfelMap:
        """The map as lines."""
        return self.state.map

    @property
    def _lost(self) -> bool:
        return self.state.bad_matches >= self.config.lost_after

    def locate(self, scan: LaserScan, segments: Segments, prior: Pose2D) -> Match:
        """Match a scan: return the pose of the sensor, given the pose of the base that odometry predicts."""
        self._facets = facets_of(scan, segments, self.config.facet_length)
        self._walls.observe(segments)
        last = self.state.T_map_base
        if last is None:
            return self._begin(prior, scan.stamp)
        T_map_laser, motion = prior @ self.T_base_laser, self._motion_covariance(last, prior, scan.stamp)
        self.state = replace(self.state, stamp=scan.stamp)
        predicted = propagate(self._predicted(last, prior, motion), prior, T_map_laser)
        found = self._find(scan, segments.noise, T_map_laser, predicted, last @ self.T_base_laser)
        self._found = found
        if found.odometry_failed:
            predicted = predicted + np.diag(pose_offset(found.fit.pose, T_map_laser.as_array()) ** 2)
        return self._fuse(found, T_map_laser, predicted, motion, propagate(motion, prior, T_map_laser))

    def add(self, scan: LaserScan, segments: Segments, T_map_laser: Pose2D) -> None:
        """Add the facets of the last located scan, if it was taken far enough from the last one that was added.

        While the robot is lost, or if the map contradicts the scan, nothing is added: errors would stay in the map.
        """
        if self._lost or (self._found is not None and self._found.contradicted):
            return
        config, added = self.map.config, self.state.T_map_added
        motion = added.between(T_map_laser) if added else Pose2D()
        distance, turn = motion.distance(Pose2D()), abs(motion.theta)
        if added is None or distance >= config.update_distance or turn >= config.update_angle:
            self.state = self._with(T_map_added=T_map_laser)
            self.map.add(self._facets, scan, T_map_laser, distance + turn)
            self._walls.add_walls(T_map_laser.theta)

    def _with(self, **changes: Any) -> SurfelMapperState:
        """Return the state with these fields changed."""
        return replace(self.state, **changes)

    def _begin(self, start: Pose2D, stamp: float) -> Match:
        """Return the match of the first scan, without a map: the pose is known, or defines the map."""
        self.state = replace(self.state, T_map_base=start, stamp=stamp)
        covariance = self._pose_covariance(start, self.state.covariance)
        return Match(Pose2D(), 0, False, 0, covariance=covariance)

    def _pose_covariance(self, pose: Pose2D, match_covariance: FloatArray) -> FloatArray:
        """Return the covariance (3, 3) of a pose of the base against the true pose, for that against the map."""
        return self.state.uncertainty.pose_covariance(pose, match_covariance)

    def _motion_covariance(self, last: Pose2D, prior: Pose2D, stamp: float) -> FloatArray:
        """Return the covariance (3, 3) of the motion since the last scan, by odometry or by the elapsed time."""
        config, before = self.config.motion, self.state.stamp
        if self._odometry:
            return motion_covariance(last.between(prior), last.theta, config)
        seconds = 0.0 if before is None else stamp - before
        return np.diag(np.full(3, max(config.without_odometry, config.speed_without_odometry * seconds) ** 2))

    def _predicted(self, last: Pose2D, prior: Pose2D, motion: FloatArray) -> FloatArray:
        """Return the covariance (3, 3) of the base at the prior.

        It is that of the last pose, plus the motion, plus recent odometry errors beyond its model.
        """
        at_prior = propagate(self.state.covariance, last, prior) + self.state.odometry_inflation * motion
        return at_prior + excess_covariance(self.state.odometry_excess)

    def _find(
        self, scan: LaserScan, noise: RangeNoise | None, prior: Pose2D, predicted: FloatArray, last: Pose2D
    ) -> Found:
        """Return the pose of the sensor that fits best; the prior if the scan is rejected."""
        settings = _for_noise(self._settings, noise)
        scene = Scene(self._facets, scan, self.map.config.no_echo_reach, self.map.grid, settings)
        last_agreed = self.state.bad_matches == 0
        found = self._search.find(scene, prior.as_array(), predicted, last.as_array(), last_agreed)
        fit = found.fit
        says_nothing = fit.inliers < UNSUPPORTED * len(self._facets) or not fit.projector.any()
        if not (found.contradicted or says_nothing):
            return found
        return found._replace(fit=fit._replace(pose=prior.as_array(), projector=np.zeros((3, 3))), odometry_only=True)

    def _fuse(
        self, found: Found, prior: Pose2D, predicted: FloatArray, motion: FloatArray, laser_motion: FloatArray
    ) -> Match:
        """Fuse the match with the prediction, and learn the accuracy of odometry.

        ``predicted`` is the covariance (3, 3) of the sensor at the prior; ``motion`` and ``laser_motion`` (3, 3) are
        those of the last motion of the base and of the sensor.
        """
        fit, config, offset = found.fit, self.config, pose_offset(found.fit.pose, prior.as_array())
        fused, innovation_squared, unconstrained = fuse(
            predicted, laser_motion, offset, fit.information, fit.projector, config.lever, config.correlation
        )
        T_map_laser = Pose2D.from_array(fit.pose)
        T_map_base = T_map_laser @ self.T_base_laser.inverse()
        covariance = propagate(fused, T_map_laser, T_map_base)
        learnt = self._learnt(found, offset, motion, innovation_squared)
        self.state = replace(self.state, T_map_base=T_map_base, covariance=covariance, **learnt)
        return Match(
            prior.between(T_map_laser),
            fit.iterations,
            fit.converged,
            len(self._facets),
            fit.inliers,
            self._pose_covariance(T_map_base, covariance),
            unconstrained,
            found.searched,
            self._lost,
            found.odometry_only,
        )

    def _learnt(
        self, found: Found, offset: FloatArray, motion: FloatArray, innovation_squared: float
    ) -> dict[str, Any]:
        """Return new fields of the state: odometry variances, larger after a contradiction, and the bad matches."""
        config, state = self.config, self.state
        most, memory = config.motion.most_growth, config.motion.memory
        inflation = memory * state.odometry_inflation + (1.0 - memory) * min(innovation_squared, 2.0 * most)
        excess = state.odometry_excess
        if not found.odometry_only:
            excess = updated_excess(excess, offset, motion, config)
        bad = found.fit.inliers < config.lost_below * len(self._facets)
        return {
            "odometry_inflation": min(max(inflation, 1.0), most),
            "odometry_excess": excess,
            "bad_matches": state.bad_matches + 1 if bad else 0,
        }


def _search_config(config: SearchConfig, odometry: bool) -> SearchConfig:
    """Return the window; without odometry it spans the heading that a robot may turn between two distant scans."""
    widest = config.window_angle if odometry else config.window_angle_without_odometry
    return config.model_copy(update={"window_angle": widest})


def _solver_settings(config: LeastSquaresConfig, odometry: bool) -> SolverSettings:
    """Return the settings; without odometry, everything counts as standing, as nothing else measures the motion."""
    shared = {name: getattr(config, name) for name in SolverSettings._fields if name != "standing_length"}
    return SolverSettings(**shared, standing_length=STANDING_LENGTH if odometry else 0.0)


def _for_noise(settings: SolverSettings, noise: RangeNoise | None) -> SolverSettings:
    """Return the settings with a kernel and a floor at least as wide as the sensor's noise."""
    near = 0.0 if noise is None else noise.near
    kernel, floor = max(settings.kernel, KERNEL_SIGMAS * near), max(settings.floor, FLOOR_SIGMAS * near)
    return settings._replace(kernel=kernel, floor=floor)
