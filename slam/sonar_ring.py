"""The sonar rings of a Pioneer P3-DX: position and direction of each transducer on the base."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from slam.pose import FloatArray, unit_vectors

_MILLIMETRES_AND_DEGREES: Final = np.array(
    [[69, 136, 90], [114, 119, 50], [148, 78, 30], [166, 27, 10],
     [166, -27, -10], [148, -78, -30], [114, -119, -50], [69, -136, -90],
     [-157, -136, -90], [-203, -119, -130], [-237, -78, -150], [-255, -27, -170],
     [-255, 27, 170], [-237, 78, 150], [-203, 119, 130], [-157, 136, 90]],
    np.float64,
)  # fmt: skip
TRANSDUCERS: Final = _MILLIMETRES_AND_DEGREES * np.array([1e-3, 1e-3, np.pi / 180.0])
"""(16, 3): x, y, bearing in the base frame, metres and radians: the front ring from left to right, then the rear one
from right to left (SonarUnit of ARIA's p3dx-sh.p)."""
FRONT: Final = 8
"""Number of transducers in the front ring."""


def echo_points(ranges: Sequence[float]) -> FloatArray:
    """Return the middles of the echoes (K, 2), base frame, from the ranges of the transducers in order.

    The range is inf without an echo.
    """
    known = np.array(ranges[: len(TRANSDUCERS)], np.float64)
    ring = TRANSDUCERS[: len(known)]
    points = ring[:, :2] + np.where(np.isfinite(known), known, 0.0)[:, None] * unit_vectors(ring[:, 2])
    return np.asarray(points[np.isfinite(known)])
