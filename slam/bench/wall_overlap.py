"""Geometry of segments against walls: how far they overlap, and how far they are apart."""

from __future__ import annotations

from typing import Final

import numpy as np

from slam.bench.scenes import VisibleWalls
from slam.lines.segments import IntArray, Segments
from slam.pose import FloatArray

STEP: Final = 0.01  # metres between the points of a segment at which phantom length is measured


def common_lengths(walls: VisibleWalls, segments: Segments) -> tuple[FloatArray, FloatArray]:
    """Metres that each segment and each wall share, projected onto the wall, and that they cover together; (W, M)."""
    along = walls.end - walls.start
    along = along / np.maximum(walls.lengths, 1e-12)[:, None]
    begin = np.sum(walls.start * along, axis=1)
    ends = np.stack([along @ segments.start.T, along @ segments.end.T]) - begin[:, None]
    low, high = ends.min(axis=0), ends.max(axis=0)
    length = walls.lengths[:, None]
    shared = np.maximum(np.minimum(high, length) - np.maximum(low, 0.0), 0.0)
    return shared, np.maximum(high, length) - np.minimum(low, 0.0)


def angles_between(walls: VisibleWalls, segments: Segments) -> FloatArray:
    """Angles between the lines, in [0, pi / 2], shape (W, M)."""
    along = walls.end - walls.start
    direction = np.arctan2(along[:, 1], along[:, 0])
    apart = np.abs(direction[:, None] - segments.theta - np.pi / 2) % np.pi
    return np.asarray(np.minimum(apart, np.pi - apart))


def offsets_between(walls: VisibleWalls, segments: Segments) -> FloatArray:
    """Distance of the middle of each wall from the line of each segment, metres, shape (W, M)."""
    middle = (walls.start + walls.end) / 2
    return np.asarray(np.abs(middle @ segments.normals.T - segments.rho))


def end_distances(walls: VisibleWalls, segments: Segments, wall: IntArray, segment: IntArray) -> FloatArray:
    """Distance from each end of these walls to the end of the segment matched to them, metres, shape (2 matches,)."""
    w = np.stack([walls.start[wall], walls.end[wall]])
    s = np.stack([segments.start[segment], segments.end[segment]])
    straight, crossed = np.linalg.norm(w - s, axis=2), np.linalg.norm(w - s[::-1], axis=2)
    return np.asarray(np.where(straight.sum(axis=0) <= crossed.sum(axis=0), straight, crossed).ravel())


def phantom_length(walls: VisibleWalls, segments: Segments, distance: float) -> float:
    """Metres of the segments that are farther than ``distance`` from every visible wall."""
    phantom = 0.0
    for start, end in zip(segments.start, segments.end, strict=True):
        length = float(np.hypot(*(end - start)))
        share = np.linspace(0.0, 1.0, max(int(length / STEP), 1) + 1)[:, None]
        phantom += length * float((distance_to_walls(walls, start + share * (end - start)) > distance).mean())
    return phantom


def distance_to_walls(walls: VisibleWalls, points: FloatArray) -> FloatArray:
    """Distance of points (N, 2) from the nearest visible wall, metres, shape (N,)."""
    along = (walls.end - walls.start)[:, None]
    to_point = points - walls.start[:, None]
    share = np.sum(to_point * along, axis=2) / np.maximum(np.sum(along * along, axis=2), 1e-12)
    gap = to_point - share.clip(0.0, 1.0)[..., None] * along
    return np.asarray(np.linalg.norm(gap, axis=2).min(axis=0, initial=np.inf))
