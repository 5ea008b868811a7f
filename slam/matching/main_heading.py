"""The heading at which the long walls of a scan lie in the main directions of the building, compiled."""

from __future__ import annotations

import numpy as np

from slam.compiled import compiled
from slam.lines.segments import Segments
from slam.mapping.directions import turn_between
from slam.pose import FloatArray

LONG = 1.0  # metres: shorter segments say too little of a direction ...
SURE = np.radians(1.0)  # ... and so do those less sure of theirs, one standard deviation
AGREE = np.radians(2.0)  # a wall lies in a direction when it is nearer to it than this
MAJORITY = 0.6  # of the long walls of a scan, by length, that must lie in one
RIVAL = 0.8  # no other heading may have this share of what the best one has
ROUNDS = 3  # of reweighting the mean


def long_walls(segments: Segments) -> FloatArray:
    """The segments that are long and sure enough: rows (M, 3) of theta (rad, sensor frame), its variance and length."""
    if segments.covariance is None:
        return np.empty((0, 3))
    return _long_walls(segments.theta, segments.start, segments.end, segments.covariance)


@compiled
def _long_walls(theta: FloatArray, start: FloatArray, end: FloatArray, covariance: FloatArray) -> FloatArray:
    walls, count = np.empty((len(theta), 3)), 0
    for m in range(len(theta)):
        length = np.hypot(end[m, 0] - start[m, 0], end[m, 1] - start[m, 1])
        if length >= LONG and covariance[m, 1, 1] <= SURE * SURE:
            walls[count, 0], walls[count, 1], walls[count, 2] = theta[m], covariance[m, 1, 1], length
            count += 1
    return walls[:count]


@compiled
def turn_to_main(walls: FloatArray, main: FloatArray, heading: float, widest: float) -> tuple[float, float]:
    """By what the sensor's heading is to be turned, at most ``widest``, and the variance of that; rad and rad^2.

    ``walls`` (M, 3) are those of ``long_walls``, ``main`` (K, 2) those of Directions. The variance is infinite where
    the walls do not tell: too few of them agree, or they agree as well at another heading.
    """
    best = turn = length = 0.0
    for m in range(len(walls)):
        length += walls[m, 2]
        for k in range(len(main)):
            off = turn_between(walls[m, 0] + heading, main[k, 0])
            agreeing = _agreeing(walls, main, heading + off) if abs(off) <= widest else 0.0
            if agreeing > best:
                best, turn = agreeing, off
    if best == 0.0 or best < MAJORITY * length or _has_rival(walls, main, heading, widest, turn, RIVAL * best):
        return 0.0, np.inf
    return _mean(walls, main, heading, turn)


@compiled
def _has_rival(walls: FloatArray, main: FloatArray, heading: float, widest: float, turn: float, enough: float) -> bool:
    """Whether at another heading of the window enough metres agree."""
    for m in range(len(walls)):
        for k in range(len(main)):
            off = turn_between(walls[m, 0] + heading, main[k, 0])
            elsewhere = abs(off) <= widest and abs(off - turn) > 2.0 * AGREE
            if elsewhere and _agreeing(walls, main, heading + off) > enough:
                return True
    return False


@compiled
def _agreeing(walls: FloatArray, main: FloatArray, heading: float) -> float:
    """Metres of wall in main directions at this heading, less where they lie less well."""
    metres = 0.0
    for m in range(len(walls)):
        off, _ = _nearest(walls[m, 0] + heading, main)
        metres += walls[m, 2] * max(0.0, 1.0 - (off / AGREE) ** 2)
    return metres


@compiled
def _mean(walls: FloatArray, main: FloatArray, heading: float, turn: float) -> tuple[float, float]:
    """The turn, as the robust mean (Tukey) of what the walls ask for, and its variance.

    Walls of one building may all be off by the same, so that many of them are no surer than one.
    """
    variance = np.inf
    for _ in range(ROUNDS):
        weights = asked = spread = 0.0
        for m in range(len(walls)):
            off, own = _nearest(walls[m, 0] + heading + turn, main)
            v = walls[m, 1] + own
            w = walls[m, 2] / v * max(0.0, 1.0 - (off / AGREE) ** 2) ** 2
            weights += w
            asked += w * off
            spread += w * v
        turn += asked / weights
        variance = spread / weights
    return turn, variance


@compiled
def _nearest(direction: float, main: FloatArray) -> tuple[float, float]:
    """From a direction to the nearest main one, and the variance of that."""
    least, variance = np.inf, 0.0
    for k in range(len(main)):
        off = turn_between(direction, main[k, 0])
        if abs(off) < abs(least):
            least, variance = off, main[k, 1]
    return least, variance
