"""The pose that fits a scan best: near the prior, in a window about it, and wherever else the robot may be.

The prior is enough where most of the scan agrees with the map there. Else a window of three standard deviations is
searched. Where what is found is still in doubt the wheels may have failed: said nothing, slipped, or been set to zero.
Then every heading is tried within some metres of the last pose, whatever they say. A pose so far from what odometry
predicts is taken only where the scan speaks for it as for no other. The map is asked what the scan should have seen
from a pose as well as what it saw: see predicted_view.py.
"""

from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import NamedTuple

import numpy as np

from slam.config import SearchConfig
from slam.mapping.free_beams import FreeBeams, free_beams
from slam.mapping.predicted_view import View, compare_view
from slam.mapping.surfel_grid import Grid
from slam.matching.coarse_search import HEADING, PLACE_X, SCORE, correlative_search
from slam.matching.global_search import GlobalSearch
from slam.matching.least_squares import Fit, SolverSettings, solve
from slam.matching.wall_heading import WallHeading
from slam.pose import FloatArray, wrap_angle
from slam.scan import LaserScan

MAX_CANDIDATES = 5  # poses of the window that are followed up ...
CANDIDATE_SPACING = 0.05  # ... whose headings are so far apart, radians
MIN_WINDOW, MIN_WINDOW_ANGLE = 0.3, 0.1  # metres and radians to each side: the smallest window
WALL_TURN = np.radians(2.0)  # how far walls may turn a prior, beside its own three standard deviations ...
MAX_WALL_TURN = np.radians(8.0)  # ... and at most
WALL_TURN_FOUND = np.radians(4.0)  # how far they may turn a pose that was found by search
SETTLED = 0.9, 0.7  # of the map that the scan bears out, and of the scan: above both no other pose is looked for
AGAINST = 0.5  # what a share of beams that passed a wall takes from the share of the scan that agrees
DOUBTED = 0.25, 0.5  # agreement of the scan with the map, of the map with the scan: in doubt below either ...
CONTRADICTED = 0.3, 0.35  # ... and the scan is not believed below both
FARTHEST = 4.0  # metres about the last pose that are searched, at most
MAX_PLACES = 20  # poses from anywhere that are followed up
ANYWHERE_SIGMA = 1.0  # metres and radians: all that is known of them
FOUND_SHARE = 1 / 3  # of the scan that must agree at a pose from anywhere ...
FOUND_GAIN = 0.35  # ... by how much more than at the pose in doubt, the beams against them counted ...
FOUND_LEAD = 2.0  # ... and by how many facets more than at any other
FOUND_TURN = 2.0  # ... and where the last pose was sure turned by less, radians: a corridor looks alike from both ends
OTHER_PLACE = 0.3, 0.15  # metres or radians, from which on two poses are different


class Found(NamedTuple):
    """The pose that was found, and how."""

    fit: Fit
    searched: bool = False
    """Beyond the prior."""
    odometry_failed: bool = False
    """Odometry had no part in it."""
    contradicted: bool = False
    """The map speaks against the pose, and there is none that is better."""
    odometry_only: bool = False
    """The pose is the prior."""


@dataclass(frozen=True, eq=False)
class Scene:
    """The scan, the map and the settings by which poses are compared."""

    facets: FloatArray
    """(F, 7)"""
    scan: LaserScan
    no_echo_reach: float
    """Metres for which a beam without an echo was free."""
    grid: Grid
    settings: SolverSettings

    @cached_property
    def beams(self) -> FreeBeams:
        """The beams of the scan; only a pose in doubt asks for them."""
        return free_beams(self.scan, self.no_echo_reach)

    @property
    def settings_found(self) -> SolverSettings:
        """Settings for a start that was found by search: it is no farther off than a pixel."""
        return self.settings._replace(first_kernel=4.0 * self.settings.kernel)


class PoseSearch:
    """Finds the pose of the sensor for a scan, in a map."""

    def __init__(self, config: SearchConfig, reach: float, walls: WallHeading) -> None:
        self._config, self._reach, self._walls = config, reach, walls

    def find(self, scene: Scene, prior: FloatArray, covariance: FloatArray, last: FloatArray, sure: bool) -> Found:
        """The best pose, for a prior (3,) and its covariance (3, 3).

        ``last`` (3,) is where the sensor was before, for ``sure`` where its scan agreed with the map there.

        The heading of the walls is asked where scans are far apart: where they overlap, the map holds the heading
        better than the building's directions, which err alike in every scan.
        """
        config, count = self._config, len(scene.facets)
        information = np.asarray(np.linalg.inv(covariance), np.float64)
        far = _apart(prior, last, config.distance, config.angle)
        refine = self._walls.refine_prior if far else _unrefined
        width, angle = 3.0 * sqrt(max(covariance[0, 0], covariance[1, 1])), 3.0 * sqrt(covariance[2, 2])
        refined, refined_information = refine(
            prior, information, float(prior[2]), min(WALL_TURN + angle, MAX_WALL_TURN)
        )
        fit = solve(scene.facets, refined, refined, refined_information, scene.grid, scene.settings)
        unsure = width > config.distance or angle > config.angle
        if fit.inliers >= config.below * count and (not (far or unsure) or self._settled(scene, fit)):
            return Found(fit)
        weighted: FloatArray = config.prior_weight * information
        fits = [fit]
        for start in self._window(scene, prior, weighted, width, angle):
            refined, refined_information = refine(prior, weighted, float(start[2]), WALL_TURN_FOUND)
            fits.append(solve(scene.facets, start, refined, refined_information, scene.grid, scene.settings_found))
        costs = [_cost(other.pose, prior, weighted) for other in fits]
        best = fits[self._best([other.inliers - cost for other, cost in zip(fits, costs, strict=True)])]
        if best.inliers >= config.below * count:
            return Found(best, True)
        best = fits[self._best([self._value(scene, other) - cost for other, cost in zip(fits, costs, strict=True)])]
        share, borne_out = best.inliers / max(count, 1), self._view(scene, best).borne_out
        if share >= DOUBTED[0] and borne_out >= DOUBTED[1]:
            return Found(best, True)
        if config.anywhere > 0.0:
            elsewhere = self._anywhere(scene, last, prior, sure, self._value(scene, best))
            if elsewhere is not None:
                return Found(elsewhere, True, odometry_failed=True)
        return Found(best, True, contradicted=share < CONTRADICTED[0] and borne_out < CONTRADICTED[1])

    def _best(self, scores: list[float]) -> int:
        """The number of the highest score; the first must be beaten by ``gain``."""
        best = int(np.argmax(scores))
        return best if scores[best] > scores[0] + self._config.gain else 0

    def _window(
        self, scene: Scene, prior: FloatArray, information: FloatArray, width: float, angle: float
    ) -> list[FloatArray]:
        """The best poses (3,) of the window, of headings well apart."""
        config = self._config
        width, angle = (
            min(config.window, max(MIN_WINDOW, width)),
            min(config.window_angle, max(MIN_WINDOW_ANGLE, angle)),
        )
        places = correlative_search(scene.facets, prior, information, width, angle, config.reach, scene.grid)
        chosen: list[FloatArray] = []
        for place in places[np.argsort(-places[:, SCORE], kind="stable")]:
            apart = all(abs(place[HEADING] - other[2]) >= CANDIDATE_SPACING for other in chosen)
            if np.isfinite(place[SCORE]) and apart:
                chosen.append(place[PLACE_X:].copy())
                if len(chosen) == MAX_CANDIDATES:
                    break
        return chosen

    def _anywhere(self, scene: Scene, last: FloatArray, prior: FloatArray, sure: bool, doubtful: float) -> Fit | None:
        """The pose about ``last`` (3,) for which the scan speaks as for no other; None where there is none.

        It must speak for it more than for the one of value ``doubtful``. The search goes as much farther as the wheels
        went, in whatever direction.
        """
        step = float(np.hypot(*(prior - last)[:2]))
        count, around = len(scene.facets), min(self._config.anywhere + step, FARTHEST)
        weak: FloatArray = self._config.prior_weight / ANYWHERE_SIGMA**2 * np.eye(3)
        fits = []
        for place in GlobalSearch(scene.grid, last[:2] - around, last[:2] + around).places(scene.facets, MAX_PLACES):
            start = place[PLACE_X:].copy()
            refined, information = self._walls.refine_prior(start, weak, float(start[2]), WALL_TURN_FOUND)
            fits.append(solve(scene.facets, start, refined, information, scene.grid, scene.settings_found))
        if not fits:
            return None
        values = [self._value(scene, fit) for fit in fits]
        first = int(np.argmax(values))
        best, highest = fits[first], values[first]
        rivals = (v for fit, v in zip(fits, values, strict=True) if _apart(fit.pose, best.pose, *OTHER_PLACE))
        leads = highest > max(rivals, default=-np.inf) + FOUND_LEAD and highest > doubtful + FOUND_GAIN * count
        agrees = best.inliers >= FOUND_SHARE * count and self._view(scene, best).borne_out >= DOUBTED[1]
        turned = min(abs(wrap_angle(float(best.pose[2] - other[2]))) for other in (last, prior))
        return best if leads and agrees and not (sure and turned > FOUND_TURN) else None

    def _value(self, scene: Scene, fit: Fit) -> float:
        """Facets that agree, less the beams that do not agree with the map, counted as facets."""
        return fit.inliers - AGAINST * self._view(scene, fit).against * len(scene.facets)

    def _settled(self, scene: Scene, fit: Fit) -> bool:
        agrees = fit.inliers >= SETTLED[1] * len(scene.facets)
        return agrees and self._view(scene, fit).borne_out >= SETTLED[0]

    def _view(self, scene: Scene, fit: Fit) -> View:
        return compare_view(scene.grid, scene.beams, scene.scan.echoes, fit.pose, self._reach)


def _unrefined(prior: FloatArray, information: FloatArray, *_: float) -> tuple[FloatArray, FloatArray]:
    return prior, information


def _cost(pose: FloatArray, prior: FloatArray, information: FloatArray) -> float:
    """Half the squared Mahalanobis distance of a pose from the prior."""
    offset = pose_offset(pose, prior)
    return 0.5 * float(offset @ information @ offset)


def _apart(pose: FloatArray, other: FloatArray, distance: float, angle: float) -> bool:
    offset = pose_offset(pose, other)
    return bool(np.hypot(offset[0], offset[1]) > distance or abs(offset[2]) > angle)


def pose_offset(pose: FloatArray, prior: FloatArray) -> FloatArray:
    """The difference (3,) of two poses, its angle within half a turn."""
    return np.array([pose[0] - prior[0], pose[1] - prior[1], wrap_angle(pose[2] - prior[2])])
