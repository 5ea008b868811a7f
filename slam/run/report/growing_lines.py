"""Which lines of the map have been seen by which scan."""

from __future__ import annotations

from typing import Final, Protocol

import numpy as np
from scipy.spatial import cKDTree

from slam.pose import FloatArray
from slam.run.results.run_record import RunRecord

_PIECE: Final = 0.08
"""Walls appear in pieces of this length, metres ..."""
_NEAR: Final = 0.12
"""... when a point of a scan lies so near to one, metres."""


class GrowingLines(Protocol):
    """A map of lines that grows scan by scan."""

    def seen(self, scan: int, points: FloatArray) -> FloatArray:
        """What is new, (M, 2, 2), metres, map frame, at this scan, whose points (N, 2) are in the map frame."""
        ...


class SeenWalls:
    """The walls of the saved map, each piece from when it was first seen."""

    def __init__(self, walls: FloatArray) -> None:
        self._unseen = _pieces(walls)

    def seen(self, scan: int, points: FloatArray) -> FloatArray:
        """The pieces near the points that no earlier scan was near."""
        if not len(points) or not len(self._unseen):
            return self._unseen[:0]
        distance, _ = cKDTree(points).query(self._unseen.mean(axis=1), distance_upper_bound=_NEAR)
        new = np.isfinite(distance)
        pieces: FloatArray = self._unseen[new]
        self._unseen = self._unseen[~new]
        return pieces


class SeenSegments:
    """The segments of every scan, where the map is the paper's: it has no other lines."""

    def __init__(self, record: RunRecord) -> None:
        self._scans, self._ends = record.segments
        self._drawn = 0

    def seen(self, scan: int, points: FloatArray) -> FloatArray:
        """Those of this scan and of the ones that were left out."""
        begin, self._drawn = self._drawn, int(np.searchsorted(self._scans, scan, side="right"))
        ends: FloatArray = self._ends[begin : self._drawn]
        return ends


def growing_lines(record: RunRecord) -> GrowingLines:
    """Of a run with a saved map its walls, of another one its segments."""
    return SeenSegments(record) if record.saved_map is None else SeenWalls(record.walls)


def _pieces(walls: FloatArray) -> FloatArray:
    """The walls cut into short pieces, (P, 2, 2)."""
    parts = [np.empty((0, 2, 2))]
    for start, end in walls:
        corners = np.linspace(start, end, 1 + max(1, round(float(np.hypot(*(end - start))) / _PIECE)))
        parts.append(np.stack([corners[:-1], corners[1:]], axis=1))
    return np.concatenate(parts)
