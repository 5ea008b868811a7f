"""The main directions of a building: those that most of its long walls have, up to quarter turns.

The walls of the map frame are gathered into clusters of directions, each a mean and a spread. A cluster is a main
direction when it has a good share of all wall seen, and a building has main directions when these have most of it.
"""

from typing import Final

import numpy as np

from slam.compiled import compiled
from slam.pose import FloatArray

QUARTER: Final = 0.5 * np.pi
DIRECTION, METRES, SQUARES = range(3)
"""Columns of clusters (K, 3): mean direction of the normals modulo a quarter turn (rad), length of wall in it (m), and
its squared deviations, less what the measurement explains, weighed by length (m rad^2)."""
THETA, VARIANCE, LENGTH = range(3)
"""Columns of walls (M, 3): direction of the normal (rad), its variance (rad^2), length (m). The first two are those of
main directions too."""
MAX_CLUSTERS = 16
JOIN_ANGLE = np.radians(2.0)  # a wall joins a mean that is nearer than this
FROZEN_AFTER = 1000.0  # metres of wall after which a mean stands still: it does not follow a drifting heading
MIN_LENGTH = 30.0  # metres of wall in a main direction, at least ...
MIN_SHARE = 0.2  # ... and of all wall seen this share
MIN_SUPPORT = 0.7  # of all wall seen, what the main directions must have together
MIN_SPREAD = np.radians(0.3)  # no building is more exact than this, one standard deviation


class Directions:
    """The clusters of the walls seen so far, and the main directions among them; of a constant size."""

    def __init__(self, clusters: FloatArray | None = None, total: float = 0.0) -> None:
        self._clusters = np.zeros((MAX_CLUSTERS, 3))
        if clusters is not None:
            self._clusters[: len(clusters)] = clusters
        self.total = total
        """Metres of all wall seen, whatever its direction."""
        self.main = np.empty((0, 2)) if clusters is None else _main(self._clusters, total)
        """Main directions (K, 2) in [0, pi / 2) and their variances, rad and rad^2; K = 0 where there is none."""

    @property
    def clusters(self) -> FloatArray:
        """All places for clusters (MAX_CLUSTERS, 3), those without metres being free."""
        return self._clusters.copy()

    def add(self, walls: FloatArray) -> None:
        """Add walls (M, 3), map frame."""
        self.total += _gather(self._clusters, walls)
        self.main = _main(self._clusters, self.total)


@compiled
def _gather(clusters: FloatArray, walls: FloatArray) -> float:
    """Put every wall into the nearest cluster, or begin one in the place of the lightest; returns the metres."""
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


@compiled
def _join(cluster: FloatArray, theta: float, metres: float, squares: float) -> None:
    """Add so many metres of this direction, with the squared deviations that they have among themselves."""
    off = quarter_turn_difference(cluster[DIRECTION], theta)
    share = metres / (cluster[METRES] + metres)
    if cluster[METRES] == 0.0:
        cluster[DIRECTION] = theta - QUARTER * np.floor(theta / QUARTER)
    elif cluster[METRES] < FROZEN_AFTER:
        direction = cluster[DIRECTION] + share * off
        cluster[DIRECTION] = direction - QUARTER * np.floor(direction / QUARTER)
    cluster[SQUARES] += squares + (metres * off * off if cluster[METRES] > 0.0 else 0.0)
    cluster[METRES] += metres


@compiled
def _merge(clusters: FloatArray, grown: int) -> None:
    """Merge clusters whose means came near to that of this one, the lighter into the heavier."""
    for k in range(len(clusters)):
        apart = abs(quarter_turn_difference(clusters[k, DIRECTION], clusters[grown, DIRECTION]))
        if k != grown and clusters[k, METRES] > 0.0 and apart < JOIN_ANGLE:
            kept, gone = (k, grown) if clusters[k, METRES] >= clusters[grown, METRES] else (grown, k)
            _join(clusters[kept], clusters[gone, DIRECTION], clusters[gone, METRES], clusters[gone, SQUARES])
            clusters[gone] = 0.0
            grown = kept


@compiled
def _main(clusters: FloatArray, total: float) -> FloatArray:
    """The main directions (K, 2) of the clusters, given the metres of all wall."""
    main, count, metres = np.empty((len(clusters), 2)), 0, 0.0
    for k in range(len(clusters)):
        if clusters[k, METRES] >= max(MIN_LENGTH, MIN_SHARE * total):
            main[count, THETA] = clusters[k, DIRECTION]
            main[count, VARIANCE] = max(clusters[k, SQUARES] / clusters[k, METRES], MIN_SPREAD * MIN_SPREAD)
            metres += clusters[k, METRES]
            count += 1
    return main[: count if metres >= MIN_SUPPORT * total else 0]


@compiled
def quarter_turn_difference(a: float, b: float) -> float:
    """The turn from direction ``a`` to ``b`` modulo a quarter turn, in [-pi / 4, pi / 4)."""
    quarters = (b - a) / QUARTER
    return float((quarters - np.floor(quarters + 0.5)) * QUARTER)
