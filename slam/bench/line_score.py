"""How well the segments of an extractor agree with the walls that a scan truly saw.

A segment matches a wall when, projected onto the wall's line, intersection over union is at least 0.5, the directions
differ by less than 10 degrees, and the line of the segment passes the middle of the wall nearer than 0.10 m. Matching
is one to one, for the greatest sum of overlaps. A segment that matches no wall is false, unless half of it lies along a
wall that is not required, nearer than 0.10 m to its middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from scipy.optimize import linear_sum_assignment

from slam.bench.scenes import VisibleWalls
from slam.bench.wall_overlap import (
    angles_between,
    common_lengths,
    end_distances,
    offsets_between,
    phantom_length,
)
from slam.lines.segments import IntArray, Segments
from slam.pose import FloatArray

MIN_OVERLAP: Final = 0.5
MAX_ANGLE: Final = np.radians(10.0)
MAX_OFFSET: Final = 0.10
PART: Final = 0.2
"""Of a wall: a segment that covers less of it is no part of it."""


@dataclass(frozen=True, slots=True, eq=False)
class LineScore:
    """What was found in one scan, or in many."""

    required: int
    found: int
    false: int
    angle_errors: FloatArray  # (found,) radians
    offsets: FloatArray  # (found,) metres, at the middle of the wall
    end_errors: FloatArray  # (2 found,) metres
    over_segmented: int
    """Required walls that two or more segments cover in part."""
    under_segmented: int
    """Segments that cover at least half of two or more required walls."""
    wall_length: float
    """Of the required walls, metres ..."""
    covered_length: float
    """... and what of it lies beside a segment."""
    segment_length: float
    """Of all segments, metres ..."""
    phantom_length: float
    """... and what of it is farther than 0.10 m from every visible wall."""

    @property
    def recall(self) -> float:
        """Share of the required walls that were found: TP."""
        return self.found / max(self.required, 1)

    @property
    def false_share(self) -> float:
        """Share of the counted segments that are false: FP."""
        return self.false / max(self.found + self.false, 1)

    @property
    def f1(self) -> float:
        """Harmonic mean of recall and precision."""
        return 2 * self.found / max(self.required + self.found + self.false, 1)

    @property
    def coverage(self) -> float:
        """Share of the length of the required walls that lies beside a segment."""
        return self.covered_length / max(self.wall_length, 1e-12)


def score_lines(walls: VisibleWalls, segments: Segments) -> LineScore:
    """Compare the segments of one scan (sensor frame; only rho, theta, start and end are used) with what it saw."""
    shared, together = common_lengths(walls, segments)
    angle, offset = angles_between(walls, segments), offsets_between(walls, segments)
    near = (angle < MAX_ANGLE) & (offset < MAX_OFFSET)
    wall, segment = _match(np.where(near, shared / np.maximum(together, 1e-12), 0.0))
    lengths, required = walls.lengths, walls.required
    idle = (shared >= 0.5 * _lengths(segments)) & (offset < MAX_OFFSET) & ~required[:, None]
    counted = np.asarray(~idle.any(axis=0))
    counted[segment] = False
    wall, segment = wall[required[wall]], segment[required[wall]]
    covered = np.where(near, shared, 0.0)[required] / np.maximum(lengths[required], 1e-12)[:, None]
    return LineScore(
        required=int(required.sum()),
        found=len(wall),
        false=int(counted.sum()),
        angle_errors=angle[wall, segment],
        offsets=offset[wall, segment],
        end_errors=end_distances(walls, segments, wall, segment),
        over_segmented=int(((covered >= PART).sum(axis=1) > 1).sum()),
        under_segmented=int(((covered >= 0.5).sum(axis=0) > 1).sum()),
        wall_length=float(lengths[required].sum()),
        covered_length=float((covered.sum(axis=1).clip(max=1.0) * lengths[required]).sum()),
        segment_length=float(_lengths(segments).sum()),
        phantom_length=phantom_length(walls, segments, MAX_OFFSET),
    )


def total(scores: Sequence[LineScore]) -> LineScore:
    """The score of many scans together."""
    columns = {field.name: [getattr(score, field.name) for score in scores] for field in fields(LineScore)}
    sums: dict[str, Any] = {
        name: np.concatenate(column) if isinstance(column[0], np.ndarray) else sum(column)
        for name, column in columns.items()
    }
    return LineScore(**sums)


def _match(overlap: FloatArray) -> tuple[IntArray, IntArray]:
    """Walls and their segments, one to one, where the overlap (W, M) reaches MIN_OVERLAP."""
    overlap = np.where(overlap >= MIN_OVERLAP, overlap, 0.0)
    wall, segment = linear_sum_assignment(overlap, maximize=True)
    matched = overlap[wall, segment] > 0.0
    return wall[matched], segment[matched]


def _lengths(segments: Segments) -> FloatArray:
    return np.asarray(np.hypot(*(segments.end - segments.start).T))
