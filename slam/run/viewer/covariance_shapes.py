"""Covariance of a pose as shapes: the 95 % ellipse of x and y, and arrows where the scan said nothing."""

from collections.abc import Sequence
from math import atan2, cos, hypot, sin
from typing import Any, Final

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from slam.pose import FloatArray
from slam.run.viewer.scene import Frame

_RADIUS_95: Final = 2.4477
"""Radius of the circle that holds 95 % of a normal distribution of unit variance in the plane: sqrt(-2 ln 0.05)."""
_ARROW: Final = 1.2
"""Metres to each side."""
_LEAST: Final = 0.05
"""Length in the plane of an unconstrained direction: below it, the direction is a heading."""


def ellipses(frames: Sequence[Frame]) -> Any:
    """Columns of a flat ellipsoid a scan, in the robot's frame; none where there is no covariance."""
    known = [(frame.robot.theta, frame.covariance) for frame in frames if frame.covariance is not None]
    counts = [int(frame.covariance is not None) for frame in frames]
    variances, axes = np.linalg.eigh(np.array([C[:2, :2] for _, C in known]).reshape(-1, 2, 2))
    sizes = np.full((len(known), 3), 1e-3, np.float32)
    sizes[:, :2] = _RADIUS_95 * np.sqrt(np.maximum(variances, 0.0))
    turns = yaw_quaternions(np.arctan2(axes[:, 1, 0], axes[:, 0, 0]) - np.array([theta for theta, _ in known]))
    return rr.Ellipsoids3D.columns(half_sizes=sizes, quaternions=turns).partition(counts)


def unconstrained_arrows(frames: Sequence[Frame]) -> Any:
    """Columns of arrows, in the robot's frame, to both sides along each direction in which odometry alone stands."""
    vectors: list[tuple[float, float, float]] = []
    counts = []
    for frame in frames:
        before = len(vectors)
        for x, y, _ in frame.unconstrained.tolist() if frame.unconstrained is not None else ():
            if hypot(x, y) > _LEAST:
                way = atan2(y, x) - frame.robot.theta
                c, s = _ARROW * cos(way), _ARROW * sin(way)
                vectors += [(c, s, 0.0), (-c, -s, 0.0)]
        counts.append(len(vectors) - before)
    return rr.Arrows3D.columns(vectors=np.array(vectors, np.float32).reshape(-1, 3)).partition(counts)


def yaw_quaternions(angles: FloatArray) -> NDArray[np.float32]:
    """Quaternions (N, 4), x y z w, of turns about the upright axis."""
    turns = np.zeros((len(angles), 4), np.float32)
    turns[:, 2], turns[:, 3] = np.sin(0.5 * angles), np.cos(0.5 * angles)
    return turns
