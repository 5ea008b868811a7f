"""The main directions of a building: the directions of most of its long walls, modulo a quarter turn.

The walls, in the map frame, are clustered by direction, each cluster with a mean and a spread. A cluster is a main
direction if it has a large share of all wall seen, and a building has main directions if these have most of it.
"""

from typing import Final

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.pose import FloatArray

QUARTER: Final = 0.5 * np.pi
DIRECTION, METRES, SQUARES = range(3)
"""Columns of clusters (K, 3): mean direction of the normals modulo a quarter turn (rad), length of wall in it (m), and
the sum of its squared deviations from the mean, weighted by length, minus their variances by measurement (m rad^2)."""
THETA, VARIANCE, LENGTH = range(3)
"""Columns of walls (M, 3): direction of the normal (rad), its variance (rad^2), length (m). The first two are those of
main directions too."""
MAX_CLUSTERS = 16
JOIN_ANGLE = np.radians(2.0)  # a wall joins a mean that is nearer than this
FROZEN_AFTER = 1000.0  # metres of wall after which a mean is fixed: it does not follow a drifting heading
MIN_LENGTH = 30.0  # least length of wall in a main direction, metres
MIN_SHARE = 0.2  # least share of a main direction in all wall seen
MIN_SUPPORT = 0.7  # least share of all main directions in all wall seen
MIN_SPREAD = np.radians(0.3)  # no building is more exact than this, one standard deviation


class Directions:
    """Clusters of the walls seen so far, and the main directions among them; the size is constant."""

    def __init__(self, clusters: FloatArray | None = None, total: float = 0.0) -> None:
        self._clusters = np.zeros((MAX_CLUSTERS, 3))
        if clusters is not None:
            self._clusters[: len(clusters)] = clusters
        self.total = total
        """Length of all wall seen, metres, in any direction."""
        self.main = np.empty((0, 2)) if clusters is None else _main(self._clusters, total)
        """Main directions (K, 2) in [0, pi / 2) and their variances, rad and rad^2; K = 0 if there is none."""

    @property
    def clusters(self) -> FloatArray:
        """All rows for clusters (MAX_CLUSTERS, 3); those without metres are free."""
        return self._clusters.copy()

    def add(self, walls: FloatArray) -> None:
        """Add walls (M, 3), map frame."""
        self.total += _gather(self._clusters, walls)
        self.main = _main(self._clusters, self.total)


@compiled_on_views
def _gather(clusters: FloatArray, walls: FloatArray) -> float:
    """Add every wall to the nearest cluster, or begin one in place of the lightest; return the metres."""
    metres = 0.0
    for m in range(len(walls)):
        theta, variance, length = walls[m]
        metres += length
        at, lightest, nearest = -1, 0, JOIN_ANGLE
        for k in range(len(clusters)):
            off = abs(quarter_turn_difference(clusters[k, DIRECTION], theta))
            if clusters[k, METRES] > 0.0 and off < nearest:
                at, nearest = k, off
            if clusters[k, METRES] < clusters[lightest, METRES]:
                lightest = k
        if at < 0:
            at = lightest
            clusters[at] = 0.0
        _join(clusters[at], theta, length, -length * variance)
        _merge(clusters, at)
    return metres


@compiled_on_views
def _join(cluster: FloatArray, theta: float, metres: float, squares: float) -> None:
    """Add ``metres`` of wall in this direction, with their squared deviations from each other."""
    off = quarter_turn_difference(cluster[DIRECTION], theta)
    share = metres / (cluster[METRES] + metres)
    if cluster[METRES] == 0.0:
        cluster[DIRECTION] = theta - QUARTER * np.floor(theta / QUARTER)
    elif cluster[METRES] < FROZEN_AFTER:
        direction = cluster[DIRECTION] + share * off
        cluster[DIRECTION] = direction - QUARTER * np.floor(direction / QUARTER)
    cluster[SQUARES] += squares + (metres * off * off if cluster[METRES] > 0.0 else 0.0)
    cluster[METRES] += metres


@compiled_on_views
def _merge(clusters: FloatArray, grown: int) -> None:
    """Merge clusters whose means came near that of this one, the lighter into the heavier."""
    for k in range(len(clusters)):
        apart = abs(quarter_turn_difference(clusters[k, DIRECTION], clusters[grown, DIRECTION]))
        if k != grown and clusters[k, METRES] > 0.0 and apart < JOIN_ANGLE:
            kept, gone = (k, grown) if clusters[k, METRES] >= clusters[grown, METRES] else (grown, k)
            _join(clusters[kept], clusters[gone, DIRECTION], clusters[gone, METRES], clusters[gone, SQUARES])
            clusters[gone] = 0.0
            grown = kept


@compiled
def _main(clusters: FloatArray, total: float) -> FloatArray:
    """Return the main directions (K, 2) of the clusters, given the length of all wall."""
    main, count, metres = np.empty((len(clusters), 2)), 0, 0.0
    for k in range(len(clusters)):
        if clusters[k, METRES] >= max(MIN_LENGTH, MIN_SHARE * total):
            main[count, THETA] = clusters[k, DIRECTION]
            main[count, VARIANCE] = max(clusters[k, SQUARES] / clusters[k, METRES], MIN_SPREAD * MIN_SPREAD)
            metres += clusters[k, METRES]
            count += 1
    return main[: count if metres >= MIN_SUPPORT * total else 0]


@compiled_on_views
def quarter_turn_difference(a: float, b: float) -> float:
    """Return the turn from direction ``a`` to ``b`` modulo a quarter turn, in [-pi / 4, pi / 4)."""
    quarters = (b - a) / QUARTER
    return float((quarters - np.floor(quarters + 0.5)) * QUARTER)
