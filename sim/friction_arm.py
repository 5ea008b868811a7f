"""Resistance to turning of what stands on the floor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from slam.pose import FloatArray
from slam.scenario.solids import Prism

STEPS: Final = 16
"""Along an edge of a footprint, and from its middle to the edge; the arm of a square is then right within 0.1 %."""


def friction_arm(prisms: Sequence[Prism]) -> float:
    """Mean distance, metres, of the area that stands on the floor from the origin.

    Times the friction of sliding, it is the moment that resists turning about the origin, for pressure that is the same
    everywhere: 2 R / 3 for a disc, L / 4 for a thin rod.
    """
    bottom = min(prism.bottom for prism in prisms)
    moments = np.sum([_moments(prism.footprint) for prism in prisms if prism.bottom == bottom], axis=0)
    return float(moments[1] / moments[0])


def _moments(footprint: FloatArray) -> FloatArray:
    """Area, and integral over it of the distance from the origin, of a convex polygon (N, 2): summed over triangles
    between its middle and its edges, each cut into STEPS x STEPS cells."""
    shares = (np.arange(STEPS) + 0.5) / STEPS
    middle = footprint.mean(axis=0)
    here, there = footprint - middle, np.roll(footprint, -1, axis=0) - middle
    doubled = here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]
    edges = here[:, None] + shares[:, None] * (there - here)[:, None]  # (N, STEPS, 2)
    points = middle + shares[:, None] * edges[:, :, None]  # (N, STEPS, STEPS, 2)
    areas = doubled[:, None, None] * shares / STEPS**2
    return np.array([areas.sum() * STEPS, (areas * np.hypot(points[..., 0], points[..., 1])).sum()])
