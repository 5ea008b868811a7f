"""This project's matcher and map: the facets of a scan are matched to surfels, with odometry as a prior."""

from dataclasses import replace
from math import sqrt

import numpy as np

from slam.config import LeastSquaresConfig
from slam.lines.facets import facets_of
from slam.lines.segments import Segments
from slam.matching.coarse_search import HEADING, PLACE_X, SCORE, correlative_search
from slam.matching.least_squares import Fit, SolverSettings, fuse, solve
from slam.matching.match import Match
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.matching.wall_heading import WallHeading
from slam.motion_model import motion_covariance, propagate
from slam.pose import FloatArray, Pose2D, wrap_angle
from slam.scan import LaserScan

MAX_CANDIDATES = 5  # poses of the search that are followed up ...
CANDIDATE_SPACING = 0.05  # ... whose headings are so far apart, radians
MIN_WINDOW, MIN_WINDOW_ANGLE = 0.3, 0.1  # metres and radians to each side: the smallest window of the search
STANDING_WAY = 1.0  # of the sensor until a small thing is believed to stand, metres and radians: legs do not so long
WALL_TURN = np.radians(2.0)  # how far walls may turn a prior, beside its own three standard deviations ...
MAX_WALL_TURN = np.radians(8.0)  # ... and at most
WALL_TURN_FOUND = np.radians(4.0)  # how far they may turn a pose that was found by search


class SurfelMapper:
    """Robust least squares on the facets of a scan and the surfels of the map."""

    def __init__(
        self, state: SurfelMapperState, config: LeastSquaresConfig, T_base_laser: Pose2D, odometry: bool = True
    ) -> None:
        self.state = state
        self.points = self.lines = self.map = state.map
        self.config, self.T_base_laser, self._odometry = config, T_base_laser, odometry
        self._settings = _solver_settings(config, odometry)
        self._facets = np.empty((0, 7))
        self._walls = WallHeading(state.directions, config.directions == "auto")

    @property
    def _lost(self) -> bool:
        return self.state.bad_matches >= self.config.lost_after

    def locate(self, scan: LaserScan, segments: Segments, prior: Pose2D) -> Match:
        """The pose of the sensor after the scan, given the pose of the base that odometry predicts."""
        self._facets = facets_of(scan, segments, self.config.facet_length)
        self._walls.observe(segments)
        state, last = self.state, self.state.T_map_base
        if last is None:
            self.state = replace(state, T_map_base=prior)
            return Match(Pose2D(), 0, False, 0, covariance=state.uncertainty.pose_covariance(prior, state.covariance))
        T_map_laser, motion = prior @ self.T_base_laser, self._motion_covariance(last, prior)
        at_prior = propagate(state.covariance, last, prior) + state.odometry_inflation * motion
        predicted = propagate(at_prior, prior, T_map_laser)
        fit, searched = self._fit(T_map_laser, predicted, last.between(prior))
        found = Pose2D.from_array(fit.pose)
        T_map_base = found @ self.T_base_laser.inverse()
        fused, unconstrained = self._fuse(fit, T_map_laser, predicted, propagate(motion, prior, T_map_laser))
        covariance = propagate(fused, found, T_map_base)
        self.state = replace(self.state, T_map_base=T_map_base, covariance=covariance)
        return Match(
            T_map_laser.between(found),
            fit.iterations,
            fit.converged,
            len(self._facets),
            fit.inliers,
            state.uncertainty.pose_covariance(T_map_base, covariance),
            unconstrained,
            searched,
            self._lost,
        )

    def add(self, scan: LaserScan, segments: Segments, T_map_laser: Pose2D) -> None:
        """Add the facets of the scan located last, where it was taken far enough from the last that was added.

        While lost nothing is added: what is put in the wrong place would stay there.
        """
        if self._lost:
            return
        config, added = self.map.config, self.state.T_map_added
        motion = added.between(T_map_laser) if added else Pose2D()
        distance, turn = motion.distance(Pose2D()), abs(motion.theta)
        if added is None or distance >= config.update_distance or turn >= config.update_angle:
            self.state = replace(self.state, T_map_added=T_map_laser)
            self.map.add(self._facets, scan, T_map_laser, distance + turn)
            self._walls.add_walls(T_map_laser.theta)

    def _motion_covariance(self, last: Pose2D, prior: Pose2D) -> FloatArray:
        if self._odometry:
            return motion_covariance(last.between(prior), last.theta, self.config.motion)
        return np.diag(np.full(3, self.config.motion.without_odometry**2))

    def _fit(self, prior: Pose2D, covariance: FloatArray, motion: Pose2D) -> tuple[Fit, bool]:
        """Fit from the prior; where that is in doubt, from the best poses of a window too. Returns the best fit, and
        whether the window was searched.

        The heading of the walls is asked where scans are far apart: where they overlap, the map holds the heading
        better than the building's directions, which err alike in every scan.
        """
        x0, information = prior.as_array(), np.asarray(np.linalg.inv(covariance), np.float64)
        search = self.config.search
        far = motion.distance(Pose2D()) > search.distance or abs(motion.theta) > search.angle
        refine = self._walls.refine_prior if far else _unrefined
        widest = min(WALL_TURN + 3.0 * sqrt(covariance[2, 2]), MAX_WALL_TURN)
        refined, refined_information = refine(x0, information, prior.theta, widest)
        fit = solve(self._facets, refined, refined, refined_information, self.map.grid, self._settings)
        if not far and fit.inliers >= search.below * len(self._facets):
            return fit, False
        weighted: FloatArray = search.prior_weight * information
        best, gain = _score(fit, x0, weighted), search.gain
        settings = self._settings._replace(first_kernel=4.0 * self._settings.kernel)
        for start in self._candidates(x0, covariance, weighted):
            refined, refined_information = refine(x0, weighted, float(start[2]), WALL_TURN_FOUND)
            other = solve(self._facets, start, refined, refined_information, self.map.grid, settings)
            score = _score(other, x0, weighted)
            if score > best + gain:
                fit, best, gain = other, score, 0.0
        return fit, True

    def _candidates(self, prior: FloatArray, covariance: FloatArray, information: FloatArray) -> list[FloatArray]:
        """The best poses (3,) of the window, of headings well apart."""
        search = self.config.search
        width = min(search.window, max(MIN_WINDOW, 3.0 * sqrt(max(covariance[0, 0], covariance[1, 1]))))
        angle = min(search.window_angle, max(MIN_WINDOW_ANGLE, 3.0 * sqrt(covariance[2, 2])))
        places = correlative_search(self._facets, prior, information, width, angle, search.reach, self.map.grid)
        chosen: list[FloatArray] = []
        for place in places[np.argsort(-places[:, SCORE], kind="stable")]:
            apart = all(abs(place[HEADING] - other[2]) >= CANDIDATE_SPACING for other in chosen)
            if np.isfinite(place[SCORE]) and apart:
                chosen.append(place[PLACE_X:].copy())
                if len(chosen) == MAX_CANDIDATES:
                    break
        return chosen

    def _fuse(
        self, fit: Fit, prior: Pose2D, predicted: FloatArray, motion: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Covariance (3, 3) of the sensor's pose, and the unconstrained directions (K, 3); odometry is inflated where
        scans contradict it, and bad matches are counted."""
        config, state = self.config, self.state
        covariance, innovation_squared, unconstrained = fuse(
            predicted, motion, _offset(fit.pose, prior.as_array()), fit.information, fit.projector, config.lever,
            config.correlation,
        )  # fmt: skip
        most, memory = config.motion.most_growth, config.motion.memory
        inflation = memory * state.odometry_inflation + (1.0 - memory) * min(innovation_squared, 2.0 * most)
        bad = fit.inliers < config.lost_below * len(self._facets)
        self.state = replace(
            state,
            odometry_inflation=min(max(inflation, 1.0), most),
            bad_matches=state.bad_matches + 1 if bad else 0,
        )
        return covariance, unconstrained


def _solver_settings(config: LeastSquaresConfig, odometry: bool) -> SolverSettings:
    """Without odometry all that is seen is believed to stand: there is nothing else to tell the motion by."""
    shared = {name: getattr(config, name) for name in SolverSettings._fields if name != "standing_way"}
    return SolverSettings(**shared, standing_way=STANDING_WAY if odometry else 0.0)


def _unrefined(prior: FloatArray, information: FloatArray, *_: float) -> tuple[FloatArray, FloatArray]:
    return prior, information


def _score(fit: Fit, prior: FloatArray, information: FloatArray) -> float:
    """Weight of the facets that agree, less half the squared Mahalanobis distance from the prior."""
    offset = _offset(fit.pose, prior)
    return fit.inliers - 0.5 * float(offset @ information @ offset)


def _offset(pose: FloatArray, prior: FloatArray) -> FloatArray:
    return np.array([pose[0] - prior[0], pose[1] - prior[1], wrap_angle(pose[2] - prior[2])])
