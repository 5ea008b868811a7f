"""A heading that does not drift, from the long walls of a scan and the main directions of a building."""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.lines.segments import Segments
from slam.mapping.directions import LENGTH, THETA, VARIANCE, Directions, quarter_turn_difference
from slam.pose import FloatArray, wrap_angle

MIN_LENGTH = 1.0  # least length of a segment, metres
MAX_SIGMA = np.radians(1.0)  # largest standard deviation of its direction
AGREEMENT_ANGLE = np.radians(2.0)  # largest deviation of a wall from its direction
MAJORITY = 0.6  # least share of the long walls of a scan, by length, that lie in one direction
RIVAL_SHARE = 0.8  # share of the best heading's score that no other heading may reach
MEAN_ROUNDS = 3  # rounds of reweighting the mean


class WallHeading:
    """Heading of the present scan from the main directions of a building, to which the scan adds its own walls."""

    def __init__(self, directions: Directions, enabled: bool = True) -> None:
        self.directions, self._enabled = directions, enabled
        self._walls = np.empty((0, 3))

    def observe(self, segments: Segments) -> None:
        """Take the segments of the present scan, sensor frame."""
        self._walls = np.empty((0, 3))
        if self._enabled and segments.covariance is not None:
            self._walls = _long_walls(segments.theta, segments.start, segments.end, segments.covariance)

    def refine_prior(
        self, prior: FloatArray, information: FloatArray, heading: float, widest: float
    ) -> tuple[FloatArray, FloatArray]:
        """Improve a prior (3,) of the sensor and its information (3, 3) by the main direction of the walls.

        The sensor may turn from ``heading`` by at most ``widest``, radians; without a main direction the prior is
        unchanged.
        """
        main = self.directions.main
        if not len(self._walls) or not len(main):
            return prior, information
        turn, variance = turn_to_main(self._walls, main, heading, widest)
        if not np.isfinite(variance):
            return prior, information
        better = information.copy()
        better[2, 2] += 1.0 / variance
        innovation = np.array([0.0, 0.0, wrap_angle(heading + turn - float(prior[2])) / variance])
        return prior + np.linalg.solve(better, innovation), better

    def add_walls(self, heading: float) -> None:
        """Add the walls of the present scan, taken with this heading of the sensor, to the directions."""
        if len(self._walls):
            self.directions.add(self._walls + np.array([heading, 0.0, 0.0]))


@compiled
def _long_walls(theta: FloatArray, start: FloatArray, end: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the segments that are long and certain enough, as walls (M, 3)."""
    walls, count = np.empty((len(theta), 3)), 0
    for m in range(len(theta)):
        length = np.hypot(end[m, 0] - start[m, 0], end[m, 1] - start[m, 1])
        variance = covariance[m, 1, 1]
        if length >= MIN_LENGTH and variance <= MAX_SIGMA * MAX_SIGMA:
            walls[count, THETA], walls[count, VARIANCE], walls[count, LENGTH] = theta[m], variance, length
            count += 1
    return walls[:count]


@compiled
def turn_to_main(walls: FloatArray, main: FloatArray, heading: float, widest: float) -> tuple[float, float]:
    """Return the turn of the sensor that aligns the walls (M, 3) with the main directions (K, 2), and its variance.

    The turn is at most ``widest``; rad and rad^2.

    The variance is infinite if the walls are not conclusive: too few of them agree, or as many agree at another
    heading.
    """
    best = turn = length = 0.0
    for m in range(len(walls)):
        length += walls[m, LENGTH]
        for k in range(len(main)):
            off = quarter_turn_difference(walls[m, THETA] + heading, main[k, THETA])
            agreeing = _agreeing(walls, main, heading + off) if abs(off) <= widest else 0.0
            if agreeing > best:
                best, turn = agreeing, off
    if best == 0.0 or best < MAJORITY * length or _has_rival(walls, main, heading, widest, turn, RIVAL_SHARE * best):
        return 0.0, np.inf
    return _mean(walls, main, heading, turn)


@compiled_on_views
def _has_rival(walls: FloatArray, main: FloatArray, heading: float, widest: float, turn: float, enough: float) -> bool:
    """Return True if another heading of the window has enough metres of agreeing wall."""
    for m in range(len(walls)):
        for k in range(len(main)):
            off = quarter_turn_difference(walls[m, THETA] + heading, main[k, THETA])
            elsewhere = abs(off) <= widest and abs(off - turn) > 2.0 * AGREEMENT_ANGLE
            if elsewhere and _agreeing(walls, main, heading + off) > enough:
                return True
    return False


@compiled_on_views
def _agreeing(walls: FloatArray, main: FloatArray, heading: float) -> float:
    """Return the metres of wall in main directions at this heading, each weighted by its fit."""
    metres = 0.0
    for m in range(len(walls)):
        off, _ = _nearest(walls[m, THETA] + heading, main)
        metres += walls[m, LENGTH] * max(0.0, 1.0 - (off / AGREEMENT_ANGLE) ** 2)
    return metres


@compiled_on_views
def _mean(walls: FloatArray, main: FloatArray, heading: float, turn: float) -> tuple[float, float]:
    """Return the robust mean (Tukey) of the turns that align the walls, and its variance.

    The walls of one building may share an error, so that many of them are no more certain than one.
    """
    variance = np.inf
    for _ in range(MEAN_ROUNDS):
        weights = turns = spread = 0.0
        for m in range(len(walls)):
            off, main_variance = _nearest(walls[m, THETA] + heading + turn, main)
            v = walls[m, VARIANCE] + main_variance
            w = walls[m, LENGTH] / v * max(0.0, 1.0 - (off / AGREEMENT_ANGLE) ** 2) ** 2
            weights += w
            turns += w * off
            spread += w * v
        turn += turns / weights
        variance = spread / weights
    return turn, variance


@compiled_on_views
def _nearest(direction: float, main: FloatArray) -> tuple[float, float]:
    """Return the turn from a direction to the nearest main one, and its variance."""
    least, variance = np.inf, 0.0
    for k in range(len(main)):
        off = quarter_turn_difference(direction, main[k, THETA])
        if abs(off) < abs(least):
            least, variance = off, main[k, VARIANCE]
    return least, variance
