"""The map of lines: the segments of every mapped scan, as in Figs. 16 and 21(c)."""

import numpy as np

from slam.lines.segments import Segments
from slam.pose import FloatArray, Pose2D


class LineMap:
    """Segments in the map frame, in the order they were seen."""

    def __init__(self) -> None:
        self._scans: list[Segments] = []

    def __len__(self) -> int:
        return sum(map(len, self._scans))

    def add(self, segments: Segments, T_map_laser: Pose2D) -> None:
        """Append the segments of one scan, given in the sensor frame."""
        self._scans.append(segments.transformed(T_map_laser))

    @property
    def ends(self) -> FloatArray:
        """Start and end point of every segment, shape (M, 2, 2): [segment, start or end, x or y]; metres, map frame."""
        return np.concatenate([np.empty((0, 2, 2)), *(np.stack([s.start, s.end], axis=1) for s in self._scans)])
