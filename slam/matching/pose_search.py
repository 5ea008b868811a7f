"""The pose that fits a scan best: near the prior, in a window about it, and wherever else the robot may be.

The prior is sufficient if most of the scan agrees with the map there. Otherwise a window of three standard deviations
is searched. If the result is still doubtful, the wheels may have failed: stopped reporting, slipped, or been reset.
Then every heading is tried within some metres of the last pose, independent of odometry. A pose so far from the
prediction of odometry is accepted only if the scan clearly favours it over all others. The comparison uses both the
walls that the scan saw and those that it should have seen from a pose: see predicted_view.py.
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

MAX_CANDIDATES = 5  # number of poses of the window that are refined
CANDIDATE_SPACING = 0.05  # least difference of their headings, radians
MIN_WINDOW, MIN_WINDOW_ANGLE = 0.3, 0.1  # metres and radians to each side: the smallest window
WALL_TURN = np.radians(2.0)  # largest turn of a prior by walls, besides three standard deviations
MAX_WALL_TURN = np.radians(8.0)  # upper bound of that turn
WALL_TURN_FOUND = np.radians(4.0)  # largest turn by walls of a pose from the search
SETTLED = 0.9, 0.7  # agreements of the map and of the scan: above both no other pose is searched
AGAINST = 0.5  # weight of beams that passed a wall against pieces that agree
DOUBTED = 0.25, 0.5  # agreements of scan and map: the pose is doubtful below either
CONTRADICTED = 0.3, 0.35  # agreements of scan and map: the scan is rejected below both
FARTHEST = 4.0  # metres about the last pose, the largest radius of the search
MAX_PLACES = 20  # number of poses from anywhere that are refined
ANYWHERE_SIGMA = 1.0  # metres and radians: standard deviation of the weak prior when they are refined
FOUND_SHARE = 1 / 3  # least share of the scan that agrees at a pose from anywhere
FOUND_GAIN = 0.35  # least gain of ``_value`` over the doubtful pose, per facet of the scan
FOUND_LEAD = 2.0  # least gain over any other pose, facets
FOUND_TURN = 2.0  # largest heading difference from a certain last pose, radians: a corridor looks alike from both ends
OTHER_PLACE = 0.3, 0.15  # metres or radians beyond which two poses are different


class Found(NamedTuple):
    """The pose that was found, and the way it was found."""

    fit: Fit
    searched: bool = False
    """True if the pose lies beyond the prior."""
    odometry_failed: bool = False
    """True if odometry was not used."""
    contradicted: bool = False
    """True if the map contradicts the pose, and there is no better one."""
    odometry_only: bool = False
    """True if the pose is the prior."""


@dataclass(frozen=True, eq=False)
class Scene:
    """The scan, the map and the settings with which poses are compared."""

    facets: FloatArray
    """(F, 7): facets."""
    scan: LaserScan
    no_echo_reach: float
    """Length for which a beam without an echo was free, metres."""
    grid: Grid
    settings: SolverSettings

    @cached_property
    def beams(self) -> FreeBeams:
        """The beams of the scan; only needed for a doubtful pose."""
        return free_beams(self.scan, self.no_echo_reach)

    @property
    def settings_found(self) -> SolverSettings:
        """Settings for a start from the search, whose error is at most one cell of the coarse search."""
        return self.settings._replace(first_kernel=4.0 * self.settings.kernel)


class PoseSearch:
    """Finds the pose of the sensor for a scan, in a map."""

    def __init__(self, config: SearchConfig, reach: float, walls: WallHeading) -> None:
        self._config, self._reach, self._walls = config, reach, walls

    def find(
        self, scene: Scene, prior: FloatArray, covariance: FloatArray, last: FloatArray, last_agreed: bool
    ) -> Found:
        """Return the best pose, for a prior (3,) and its covariance (3, 3).

        ``last`` (3,) is the previous pose of the sensor; ``last_agreed`` is True if its scan agreed with the map there.

        The building's directions correct the heading only if the robot moved far since the last scan. If it did not,
        matching to the map is more accurate than they are, as their error is the same in every scan.
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
        share, supported = best.inliers / max(count, 1), self._view(scene, best).supported
        if share >= DOUBTED[0] and supported >= DOUBTED[1]:
            return Found(best, True)
        if config.anywhere > 0.0:
            elsewhere = self._anywhere(scene, last, prior, last_agreed, self._value(scene, best))
            if elsewhere is not None:
                return Found(elsewhere, True, odometry_failed=True)
        return Found(best, True, contradicted=share < CONTRADICTED[0] and supported < CONTRADICTED[1])

    def _best(self, scores: list[float]) -> int:
        """Return the index of the highest score; the first must be beaten by ``gain``."""
        best = int(np.argmax(scores))
        return best if scores[best] > scores[0] + self._config.gain else 0

    def _window(
        self, scene: Scene, prior: FloatArray, information: FloatArray, width: float, angle: float
    ) -> list[FloatArray]:
        """Return the best poses (3,) of the window, with clearly different headings."""
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

    def _anywhere(
        self, scene: Scene, last: FloatArray, prior: FloatArray, last_agreed: bool, doubtful: float
    ) -> Fit | None:
        """Return the pose about ``last`` (3,) that the scan clearly favours over all others; None if there is none.

        It must be better than the doubtful one of value ``doubtful``. The search radius grows with the distance that
        the wheels measured.
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
        agrees = best.inliers >= FOUND_SHARE * count and self._view(scene, best).supported >= DOUBTED[1]
        turned = min(abs(wrap_angle(float(best.pose[2] - other[2]))) for other in (last, prior))
        return best if leads and agrees and not (last_agreed and turned > FOUND_TURN) else None

    def _value(self, scene: Scene, fit: Fit) -> float:
        """Return the number of agreeing facets, minus the beams that disagree with the map, counted as facets."""
        return fit.inliers - AGAINST * self._view(scene, fit).against * len(scene.facets)

    def _settled(self, scene: Scene, fit: Fit) -> bool:
        agrees = fit.inliers >= SETTLED[1] * len(scene.facets)
        return agrees and self._view(scene, fit).supported >= SETTLED[0]

    def _view(self, scene: Scene, fit: Fit) -> View:
        return compare_view(scene.grid, scene.beams, scene.scan.echoes, fit.pose, self._reach)


def _unrefined(prior: FloatArray, information: FloatArray, *_: float) -> tuple[FloatArray, FloatArray]:
    return prior, information


def _cost(pose: FloatArray, prior: FloatArray, information: FloatArray) -> float:
    """Return half the squared Mahalanobis distance of a pose from the prior."""
    offset = pose_offset(pose, prior)
    return 0.5 * float(offset @ information @ offset)


def _apart(pose: FloatArray, other: FloatArray, distance: float, angle: float) -> bool:
    offset = pose_offset(pose, other)
    return bool(np.hypot(offset[0], offset[1]) > distance or abs(offset[2]) > angle)


def pose_offset(pose: FloatArray, prior: FloatArray) -> FloatArray:
    """Return the difference (3,) of two poses, with its angle within half a turn."""
    return np.array([pose[0] - prior[0], pose[1] - prior[1], wrap_angle(pose[2] - prior[2])])
