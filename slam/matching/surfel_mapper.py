"""This project's matcher and map: the facets of a scan are matched to surfels, with odometry as a prior."""

from __future__ import annotations

from math import sqrt

import numpy as np

from slam.config import LeastSquaresConfig
from slam.lines.facets import facets_of
from slam.lines.segments import Segments
from slam.matching.coarse_search import best_of_window
from slam.matching.least_squares import Fit, SolverSettings, fuse, solve
from slam.matching.match import Match
from slam.matching.surfel_memory import SurfelMemory
from slam.matching.wall_heading import WallHeading
from slam.motion_model import motion_covariance, propagate
from slam.pose import FloatArray, Pose2D, wrap_angle
from slam.scan import LaserScan

APART = 0.05  # radians between two headings of the search that are followed up ...
FOLLOWED = 5  # ... so many at most
LEAST_SEARCH = 0.3, 0.1  # metres and radians: the smallest window
STEERED = np.radians(2.0), np.radians(8.0)  # how far walls may turn a prior: beside its own three deviations, at most
STEERED_FOUND = np.radians(4.0)  # ... and a pose that was found by search


class SurfelMapper:
    """Robust least squares on the facets of a scan and the surfels of the map."""

    def __init__(
        self, memory: SurfelMemory, config: LeastSquaresConfig, T_base_laser: Pose2D, odometry: bool = True
    ) -> None:
        self.points = self.lines = self.map = memory.map
        self.config, self.T_base_laser, self._odometry = config, T_base_laser, odometry
        self._settings = SolverSettings(*(getattr(config, name) for name in SolverSettings._fields))
        self._drift, self._growth, self._misfits = memory.drift, memory.growth, memory.misfits
        self._last, self._added = memory.T_map_base, memory.T_map_added
        self._covariance = memory.covariance  # of the base at _last, against the map
        self._facets = np.empty((0, 7))
        self._walls = WallHeading(memory.directions, config.directions == "auto")

    @property
    def memory(self) -> SurfelMemory:
        """What a mapper is made from that goes on where this one stands; the map and its drift are shared."""
        return SurfelMemory(
            self.map, self._drift, self._last, self._added, self._covariance, self._growth, self._misfits,
            self._walls.directions,
        )  # fmt: skip

    def locate(self, scan: LaserScan, segments: Segments, prior: Pose2D) -> Match:
        """The pose of the sensor after the scan, given the pose of the base that odometry predicts."""
        self._facets = facets_of(scan, segments, self.config.facet_length)
        self._walls.observe(segments)
        if self._last is None:
            self._last = prior
            return Match(Pose2D(), 0, False, 0, covariance=self._drift.covariance(prior, self._covariance))
        T_map_laser, motion = prior @ self.T_base_laser, self._motion_covariance(self._last, prior)
        at_prior = propagate(self._covariance, self._last, prior) + self._growth * motion
        predicted = propagate(at_prior, prior, T_map_laser)
        fit, searched = self._fit(T_map_laser, predicted, self._last.between(prior))
        found = Pose2D.from_array(fit.pose)
        unconstrained = self._learn(fit, T_map_laser.as_array(), predicted, propagate(motion, prior, T_map_laser))
        self._last = found @ self.T_base_laser.inverse()
        self._covariance = propagate(self._covariance, found, self._last)
        return Match(
            T_map_laser.between(found),
            fit.iterations,
            fit.converged,
            len(self._facets),
            fit.inliers,
            self._drift.covariance(self._last, self._covariance),
            unconstrained,
            searched,
            self._misfits >= self.config.lost_after,
        )

    def add(self, scan: LaserScan, segments: Segments, T_map_laser: Pose2D) -> None:
        """Add the facets of the scan located last, where it was taken far enough from the last that was added.

        While lost nothing is added: what is put in the wrong place would stay there.
        """
        if self._misfits >= self.config.lost_after:
            return
        config, added = self.map.config, self._added
        if added is None or (
            added.distance(T_map_laser) >= config.update_distance
            or abs(wrap_angle(T_map_laser.theta - added.theta)) >= config.update_angle
        ):
            self._added = T_map_laser
            self.map.add(self._facets, scan, T_map_laser)
            self._walls.add_walls(T_map_laser.theta)

    def _motion_covariance(self, last: Pose2D, prior: Pose2D) -> FloatArray:
        if self._odometry:
            return motion_covariance(last.between(prior), last.theta, self.config.motion)
        return np.diag(np.full(3, self.config.motion.without_odometry**2))

    def _fit(self, prior: Pose2D, covariance: FloatArray, motion: Pose2D) -> tuple[Fit, bool]:
        """From the prior; where that is in doubt, from the best poses of a window too. And whether it was.

        The heading of the walls is asked where scans are far apart: where they overlap, the map holds the heading
        better than the building's directions, which err alike in every scan.
        """
        x0, information = prior.as_array(), np.asarray(np.linalg.inv(covariance), np.float64)
        search = self.config.search
        far = motion.distance(Pose2D()) > search.distance or abs(motion.theta) > search.angle
        steer = self._walls.refine_prior if far else _unsteered
        widest = min(STEERED[0] + 3.0 * sqrt(covariance[2, 2]), STEERED[1])
        likely, sure = steer(x0, information, prior.theta, widest)
        fit = solve(self._facets, likely, likely, sure, self.map.grid, self._settings)
        if not far and fit.inliers >= search.below * len(self._facets):
            return fit, False
        weighed: FloatArray = search.prior_weight * information
        best, gain = self._score(fit, x0, weighed), search.gain
        for start in self._candidates(x0, covariance, weighed):
            settings = self._settings._replace(first_kernel=4.0 * self._settings.kernel)
            likely, sure = steer(x0, weighed, float(start[2]), STEERED_FOUND)
            other = solve(self._facets, start, likely, sure, self.map.grid, settings)
            score = self._score(other, x0, weighed)
            if score > best + gain:
                fit, best, gain = other, score, 0.0
        return fit, True

    def _candidates(self, prior: FloatArray, covariance: FloatArray, weighed: FloatArray) -> list[FloatArray]:
        """The best poses of the window, of headings well apart."""
        search = self.config.search
        width = min(search.window, max(LEAST_SEARCH[0], 3.0 * sqrt(max(covariance[0, 0], covariance[1, 1]))))
        angle = min(search.window_angle, max(LEAST_SEARCH[1], 3.0 * sqrt(covariance[2, 2])))
        rows = best_of_window(self._facets, prior, weighed, width, angle, search.reach, self.map.grid)
        chosen: list[FloatArray] = []
        for row in rows[np.argsort(-rows[:, 0], kind="stable")]:
            if np.isfinite(row[0]) and all(abs(row[3] - other[2]) >= APART for other in chosen):
                chosen.append(row[1:].copy())
                if len(chosen) == FOLLOWED:
                    break
        return chosen

    @staticmethod
    def _score(fit: Fit, prior: FloatArray, weighed: FloatArray) -> float:
        offset = _offset(fit.pose, prior)
        return fit.inliers - 0.5 * float(offset @ weighed @ offset)

    def _learn(self, fit: Fit, prior: FloatArray, predicted: FloatArray, motion: FloatArray) -> FloatArray:
        """Keep the covariance of the sensor's pose, trust odometry less where scans contradict it, count misfits;
        returns the unconstrained directions."""
        config, offset = self.config, _offset(fit.pose, prior)
        self._covariance, surprise, unconstrained = fuse(
            predicted, motion, offset, fit.information, fit.projector, config.lever, config.correlation
        )
        most, memory = config.motion.most_growth, config.motion.memory
        growth = memory * self._growth + (1.0 - memory) * min(surprise, 2.0 * most)
        self._growth = min(max(growth, 1.0), most)
        self._misfits = self._misfits + 1 if fit.inliers < config.lost_below * len(self._facets) else 0
        return unconstrained


def _unsteered(prior: FloatArray, information: FloatArray, *_: float) -> tuple[FloatArray, FloatArray]:
    return prior, information


def _offset(pose: FloatArray, prior: FloatArray) -> FloatArray:
    return np.array([pose[0] - prior[0], pose[1] - prior[1], wrap_angle(pose[2] - prior[2])])
