"""Upright prisms, of which every thing of a world is made, and the distances of points from them.

Metres and radians, map frame; the floor is z = 0.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import acos, ceil, pi
from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scenario.values import Point

_CHORD: Final = 1e-3
"""Largest deviation of a polygon from its circle, metres."""
ROBOT_RADIUS: Final = 0.25
"""Radius around the robot that must be free, metres: more than half its width, less than half its length."""
SILL: Final = 0.025
"""Height of a solid that the robot can drive over, metres: the step in the P3-DX's data sheet."""
ROBOT_SPAN: Final = (SILL, 0.4)
"""Heights between which a solid blocks the robot, metres."""
_PAIRS: Final = 20_000
"""Number of points times edges whose distances are computed at once: few enough for the cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """A solid with the outline ``footprint`` (N, 2), counter-clockwise and convex, from ``bottom`` up to ``top``."""

    footprint: FloatArray
    bottom: float
    top: float


def outlines_at(prisms: Iterable[Prism], height: float) -> list[FloatArray]:
    """List the outlines (N, 2) of those prisms that a horizontal plane at this height cuts."""
    return [prism.footprint for prism in prisms if prism.bottom <= height <= prism.top]


def rectangle(center: Point, length: float, width: float, yaw: float) -> FloatArray:
    """Make the corners (4, 2) of a rectangle, counter-clockwise; ``length`` lies along ``yaw``."""
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * [length, width]
    return Pose2D(*center, yaw).transform(corners)


def disc(center: Point, radius: float) -> FloatArray:
    """Make a regular polygon (N, 2) inscribed in a circle, counter-clockwise; it deviates from it by at most 1 mm."""
    sides = max(8, ceil(pi / acos(max(1.0 - _CHORD / radius, 0.0))))
    angles = np.arange(sides) * (2.0 * pi / sides)
    return radius * unit_vectors(angles) + center


def obstacle_footprints(prisms: Sequence[Prism]) -> list[FloatArray]:
    """List the footprints of the solids that block the robot."""
    low, high = ROBOT_SPAN
    return [prism.footprint for prism in prisms if prism.bottom < high and prism.top > low]


def clearance(points: FloatArray, footprints: Sequence[FloatArray]) -> FloatArray:
    """Return the distance of each of the points (N, 2) from the nearest convex, counter-clockwise footprint.

    Metres, (N,); 0 inside one; infinite without a footprint.
    """
    if not footprints:
        return np.full(len(points), np.inf)
    start = np.concatenate(footprints)
    first = np.cumsum([0, *map(len, footprints)])
    following = np.arange(1, len(start) + 1)
    following[first[1:] - 1] = first[:-1]
    edge = start[following] - start
    rows = max(_PAIRS // len(start), 1)
    blocks = (points[k : k + rows] for k in range(0, len(points), rows))
    return np.concatenate([np.empty(0), *(_clearance(block, start, edge, first[:-1]) for block in blocks)])


def _clearance(points: FloatArray, start: FloatArray, edge: FloatArray, first: NDArray[np.intp]) -> FloatArray:
    """Return the clearance of few points; outline k begins with edge ``first[k]``."""
    across, up = points[:, :1] - start[:, 0], points[:, 1:] - start[:, 1]
    squared = np.maximum((edge**2).sum(axis=1), np.finfo(np.float64).tiny)
    along = np.clip((across * edge[:, 0] + up * edge[:, 1]) / squared, 0.0, 1.0)
    distance = np.sqrt(((across - along * edge[:, 0]) ** 2 + (up - along * edge[:, 1]) ** 2).min(axis=1))
    left_of_edge = edge[:, 0] * up - edge[:, 1] * across
    inside = (np.minimum.reduceat(left_of_edge, first, axis=1) >= 0.0).any(axis=1)
    return np.where(inside, 0.0, distance)


def sample_path(path: Sequence[tuple[float, float]] | FloatArray, step: float = 0.05) -> FloatArray:
    """Sample points (N, 2) on a polyline, no more than ``step`` metres apart, its corners among them."""
    corners = np.asarray(path, np.float64)
    parts = [corners[:1]]
    for a, b in pairwise(corners):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / step)))
        parts.append(a + (b - a) * np.linspace(0.0, 1.0, count + 1)[1:, np.newaxis])
    return np.concatenate(parts)
