"""A line map by association: each segment of a scan is merged into the line of the map that it continues.

This is the usual method of the literature (e.g. Pfister, Roumeliotis, Burdick, ICRA 2003), here without covariances.
"""

from typing import Final

import numpy as np

from slam.lines.segments import Segments
from slam.pose import FloatArray, Pose2D

SAME_WAY: Final = float(np.cos(np.radians(10.0)))
"""Least cosine between a segment and the line that it continues."""
OFFSET: Final = 0.10
"""Largest distance of the segment's ends from that line, metres."""
GAP: Final = 0.20
"""Largest gap between the two along the line, metres."""
W, WX, WY, WXX, WXY, WYY = range(6)


class MergedLines:
    """Lines in the map frame, each the best fit to the points of all segments that were merged into it."""

    def __init__(self) -> None:
        self.ends = np.empty((0, 2, 2))
        """[line, start or end, x or y], metres; the lidar was to the left of the line."""
        self._sums = np.empty((0, 6))

    def add(self, segments: Segments, T_map_laser: Pose2D) -> None:
        """Merge the segments of one scan, given in the sensor frame."""
        moved = segments.transformed(T_map_laser)
        for start, end, count in zip(moved.start, moved.end, moved.counts, strict=True):
            segment = np.stack([start, end])
            self._merge(segment, _sums_of(segment, float(count)))

    def _merge(self, line: FloatArray, sums: FloatArray) -> None:
        """Add a line (2, 2) with its sums, merged with every line of the map that it continues.

        A merged line may continue further ones.
        """
        while (at := self._continued(line)) is not None:
            sums = sums + self._sums[at]
            line = _line_through(sums, np.concatenate([line, self.ends[at]]))
            self.ends, self._sums = np.delete(self.ends, at, axis=0), np.delete(self._sums, at, axis=0)
        self.ends, self._sums = np.append(self.ends, line[None], axis=0), np.append(self._sums, sums[None], axis=0)

    def _continued(self, line: FloatArray) -> int | None:
        """Return the nearest line of the map that this one (2, 2) continues; None if there is none."""
        directions, direction = _directions(self.ends), _directions(line[None])
        to_line, to_others = line - self.ends[:, :1], self.ends - line[0]
        lengths = np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T)
        along = np.sum(to_line * directions[:, None], axis=2)
        across = np.minimum(_greatest_offset(to_line, directions), _greatest_offset(to_others, direction))
        touches = (along.max(axis=1) >= -GAP) & (along.min(axis=1) <= lengths + GAP)
        chosen = np.flatnonzero((directions @ direction[0] >= SAME_WAY) & touches & (across <= OFFSET))
        return int(chosen[np.argmin(across[chosen])]) if len(chosen) else None


def _directions(lines: FloatArray) -> FloatArray:
    """Unit vectors along the lines (M, 2, 2), shape (M, 2)."""
    directions = lines[:, 1] - lines[:, 0]
    return np.asarray(directions / np.maximum(np.hypot(*directions.T), 1e-12)[:, None])


def _greatest_offset(ends: FloatArray, directions: FloatArray) -> FloatArray:
    """Return the larger distance of two points (M, 2, 2) from the line along ``directions`` through the origin, (M,).

    ``directions`` are one or M unit vectors.
    """
    return np.asarray(np.abs(ends[..., 1] * directions[:, None, 0] - ends[..., 0] * directions[:, None, 1]).max(axis=1))


def _sums_of(segment: FloatArray, count: float) -> FloatArray:
    """Return sums over ``count`` points spread evenly along the segment (2, 2): of 1, x, y, xx, xy, yy."""
    (x, y), (dx, dy) = segment.mean(axis=0), segment[1] - segment[0]
    second = x * x + dx * dx / 12.0, x * y + dx * dy / 12.0, y * y + dy * dy / 12.0
    return count * np.array([1.0, x, y, *second])


def _line_through(sums: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the best line (2, 2) of these sums, from the first to the last projection of the ends (K, 2).

    Its direction is from the first end to the second.
    """
    mean = sums[[WX, WY]] / sums[W]
    xx, xy, yy = sums[[WXX, WXY, WYY]] / sums[W] - [mean[0] ** 2, mean[0] * mean[1], mean[1] ** 2]
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    direction = np.array([np.cos(angle), np.sin(angle)])
    direction = direction if direction @ (ends[1] - ends[0]) >= 0.0 else -direction
    along = (ends - mean) @ direction
    return np.stack([mean + along.min() * direction, mean + along.max() * direction])
