"""Score of an extractor: agreement of its segments with the walls that a scan saw.

A segment matches a wall if their intersection over union along the wall's line is at least 0.5, their directions differ
by less than 10 degrees, and the distance of the segment's line from the middle of the wall is below 0.10 m. Matching is
one to one and maximises the sum of overlaps. A segment that matches no wall is false; but one that lies by half on a
wall that is not required, within 0.10 m of its middle, is ignored.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from scipy.optimize import linear_sum_assignment

from slam.bench.scenes import VisibleWalls
from slam.lines.segments import IntArray, Segments
from slam.pose import FloatArray

MIN_OVERLAP: Final = 0.5
MAX_ANGLE: Final = np.radians(10.0)
MAX_OFFSET: Final = 0.10


@dataclass(frozen=True, slots=True, eq=False)
class LineScore:
    """Walls found and missed in one scan, or in many."""

    required: int
    found: int
    false: int
    angle_errors: FloatArray  # (found,) radians
    offsets: FloatArray  # (found,) metres, at the middle of the wall
    end_errors: FloatArray  # (2 found,) metres

    @property
    def recall(self) -> float:
        """Share of the required walls that were found: the true positive rate."""
        return self.found / max(self.required, 1)

    @property
    def false_share(self) -> float:
        """Share of the counted segments that are false."""
        return self.false / max(self.found + self.false, 1)

    @property
    def f1(self) -> float:
        """Harmonic mean of recall and precision."""
        return 2 * self.found / max(self.required + self.found + self.false, 1)


def score_lines(walls: VisibleWalls, segments: Segments) -> LineScore:
    """Score the segments of one scan, sensor frame; only rho, theta, start and end are used."""
    shared, together = _common_lengths(walls, segments)
    angle, offset = _angles_between(walls, segments), _offsets_between(walls, segments)
    near = (angle < MAX_ANGLE) & (offset < MAX_OFFSET)
    wall, segment = _match(np.where(near, shared / np.maximum(together, 1e-12), 0.0))
    required, lengths = walls.required, np.hypot(*(segments.end - segments.start).T)
    optional = (shared >= 0.5 * lengths) & (offset < MAX_OFFSET) & ~required[:, None]
    counted = np.asarray(~optional.any(axis=0))
    counted[segment] = False
    wall, segment = wall[required[wall]], segment[required[wall]]
    return LineScore(
        required=int(required.sum()),
        found=len(wall),
        false=int(counted.sum()),
        angle_errors=angle[wall, segment],
        offsets=offset[wall, segment],
        end_errors=_end_distances(walls, segments, wall, segment),
    )


def total_score(scores: Sequence[LineScore]) -> LineScore:
    """Add up the scores of many scans."""
    columns = {field.name: [getattr(score, field.name) for score in scores] for field in fields(LineScore)}
    sums: dict[str, Any] = {
        name: np.concatenate(column) if isinstance(column[0], np.ndarray) else sum(column)
        for name, column in columns.items()
    }
    return LineScore(**sums)


def _match(overlap: FloatArray) -> tuple[IntArray, IntArray]:
    """Assign walls to segments one to one, if their overlap (W, M) reaches MIN_OVERLAP."""
    overlap = np.where(overlap >= MIN_OVERLAP, overlap, 0.0)
    wall, segment = linear_sum_assignment(overlap, maximize=True)
    matched = overlap[wall, segment] > 0.0
    return wall[matched], segment[matched]


def _common_lengths(walls: VisibleWalls, segments: Segments) -> tuple[FloatArray, FloatArray]:
    """Return the overlap of each segment and wall, projected onto the wall, and the length of their union, metres.

    The arrays have shape (W, M).
    """
    along = walls.end - walls.start
    along = along / np.maximum(walls.lengths, 1e-12)[:, None]
    begin = np.sum(walls.start * along, axis=1)
    ends = np.stack([along @ segments.start.T, along @ segments.end.T]) - begin[:, None]
    low, high = ends.min(axis=0), ends.max(axis=0)
    length = walls.lengths[:, None]
    shared = np.maximum(np.minimum(high, length) - np.maximum(low, 0.0), 0.0)
    return shared, np.maximum(high, length) - np.minimum(low, 0.0)


def _angles_between(walls: VisibleWalls, segments: Segments) -> FloatArray:
    """Return the angles between the lines, in [0, pi / 2], shape (W, M)."""
    along = walls.end - walls.start
    direction = np.arctan2(along[:, 1], along[:, 0])
    apart = np.abs(direction[:, None] - segments.theta - np.pi / 2) % np.pi
    return np.asarray(np.minimum(apart, np.pi - apart))


def _offsets_between(walls: VisibleWalls, segments: Segments) -> FloatArray:
    """Return the distance of the middle of each wall from the line of each segment, metres, shape (W, M)."""
    middle = (walls.start + walls.end) / 2
    return np.asarray(np.abs(middle @ segments.normals.T - segments.rho))


def _end_distances(walls: VisibleWalls, segments: Segments, wall: IntArray, segment: IntArray) -> FloatArray:
    """Return the distance of each end of these walls from the end of its segment, metres, shape (2 matches,)."""
    w = np.stack([walls.start[wall], walls.end[wall]])
    s = np.stack([segments.start[segment], segments.end[segment]])
    straight, crossed = np.linalg.norm(w - s, axis=2), np.linalg.norm(w - s[::-1], axis=2)
    return np.asarray(np.where(straight.sum(axis=0) <= crossed.sum(axis=0), straight, crossed).ravel())
