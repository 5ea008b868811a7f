"""Upright prisms: what every thing of a world is made of. Metres and radians, map frame; the floor is z = 0."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, ceil, pi
from typing import Final

import numpy as np

from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scenario.values import Point

_CHORD: Final = 1e-3
"""A polygon that stands for a circle deviates from it by no more than this, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """A solid with the outline ``footprint`` (N, 2), counter-clockwise and convex, from ``bottom`` up to ``top``."""

    footprint: FloatArray
    bottom: float
    top: float


def rectangle(center: Point, length: float, width: float, yaw: float) -> FloatArray:
    """Corners (4, 2), counter-clockwise; ``length`` lies along ``yaw``."""
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * [length, width]
    return Pose2D(*center, yaw).transform(corners)


def disc(center: Point, radius: float) -> FloatArray:
    """Corners (N, 2), counter-clockwise, of a regular polygon in the circle, less than 1 mm inside it everywhere."""
    sides = max(8, ceil(pi / acos(max(1.0 - _CHORD / radius, 0.0))))
    angles = np.arange(sides) * (2.0 * pi / sides)
    return radius * unit_vectors(angles) + center
