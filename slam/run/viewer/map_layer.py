"""The map, sent again now and then: the larger it is, the more seldom, so that a scan never costs more for it."""

from __future__ import annotations

from typing import Final, NamedTuple

from slam.pose import FloatArray
from slam.run.estimator import Estimator
from slam.run.viewer.frame import Frame

_BYTES_A_SCAN: Final = 500.0
_LEAST_WAIT: Final = 20
"""Scans."""
_MOST_POINTS, _MOST_LINES = 4000, 2000
"""A larger map is thinned evenly."""


class MapAt(NamedTuple):
    """The map as it was at one scan."""

    scan: int
    stamp: float
    points: FloatArray
    """(N, 2)."""
    ends: FloatArray
    """(M, 2, 2)."""


class MapLayer:
    """Watches how a map grows."""

    def __init__(self, slam: Estimator) -> None:
        self._slam = slam
        self._shown, self._due = -1, 0

    def due(self, frame: Frame, last: bool = False) -> MapAt | None:
        """The map at this scan, if it has changed and is due, or is the last."""
        size = len(self._slam.points)
        if not size or (frame.index < self._due and not last) or size == self._shown:
            return None
        points = _thinned(self._slam.points.points, _MOST_POINTS)
        lines = _thinned(self._slam.lines.ends, _MOST_LINES)
        sent = 12 * len(points) + 24 * len(lines)
        self._shown, self._due = size, frame.index + max(_LEAST_WAIT, round(sent / _BYTES_A_SCAN))
        return MapAt(frame.index, frame.stamp, points, lines)


def _thinned(array: FloatArray, most: int) -> FloatArray:
    return array[:: len(array) // most + 1].copy()  # the map goes on growing
