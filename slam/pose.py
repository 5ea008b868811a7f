"""Poses in the plane: the group SE(2).

``T_a_b`` is the pose of frame ``b`` in frame ``a``: it takes coordinates in ``b`` to coordinates in ``a``, so
``T_map_laser = T_map_base @ T_base_laser``. Axes follow REP-103: x forward, y left, angles counter-clockwise.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import atan2, cos, hypot, pi, remainder, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def wrap_angle(angle: float) -> float:
    """Wrap an angle to (-pi, pi]; radians."""
    wrapped = remainder(angle, 2.0 * pi)
    return pi if wrapped == -pi else wrapped


def wrap_angles(angles: FloatArray) -> FloatArray:
    """Wrap angles, any shape, to [-pi, pi]; radians."""
    return np.pi - np.remainder(np.pi - angles, 2.0 * np.pi)


def unit_vectors(angles: NDArray[np.floating[Any]]) -> FloatArray:
    """Return cosine and sine of angles (N,), shape (N, 2)."""
    return np.asarray(np.column_stack([np.cos(angles), np.sin(angles)]), np.float64)


@dataclass(frozen=True, slots=True)
class Pose2D:
    """An element of SE(2): metres and radians; ``theta`` is kept as given, and wrapped by the operations."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    @classmethod
    def from_array(cls, row: FloatArray) -> Pose2D:
        """Make the pose of an array (3,) of x, y and theta."""
        x, y, theta = row.tolist()
        return cls(x, y, theta)

    def as_array(self) -> FloatArray:
        """Return x, y and theta, shape (3,)."""
        return np.array([self.x, self.y, self.theta])

    def __matmul__(self, other: Pose2D) -> Pose2D:
        """Compose: ``T_a_c = T_a_b @ T_b_c``."""
        c, s = cos(self.theta), sin(self.theta)
        return Pose2D(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.theta + other.theta),
        )

    def inverse(self) -> Pose2D:
        """Return ``T_b_a`` of ``T_a_b``."""
        c, s = cos(self.theta), sin(self.theta)
        return Pose2D(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.theta))

    def between(self, other: Pose2D) -> Pose2D:
        """Return ``T_self_other`` from this pose to the other, both given in one frame."""
        return self.inverse() @ other

    def distance(self, other: Pose2D) -> float:
        """Return the distance between the two origins, metres."""
        return hypot(other.x - self.x, other.y - self.y)

    def bearing(self, other: Pose2D) -> float:
        """Return the direction of the other's origin, seen from this pose, (-pi, pi] radians."""
        return wrap_angle(atan2(other.y - self.y, other.x - self.x) - self.theta)

    @property
    def rotation(self) -> FloatArray:
        """Rotation matrix T(theta) of eq. (16), shape (2, 2)."""
        c, s = cos(self.theta), sin(self.theta)
        return np.array([[c, -s], [s, c]])

    @property
    def translation(self) -> FloatArray:
        """Position x, y, shape (2,), metres."""
        return np.array([self.x, self.y])

    def transform(self, points: FloatArray) -> FloatArray:
        """Transform points (N, 2) from frame ``b`` to frame ``a``: eq. (17)."""
        return points @ self.rotation.T + self.translation


def stack_poses(poses: Iterable[Pose2D]) -> FloatArray:
    """Return rows (K, 3) of x, y and theta."""
    return np.array([(pose.x, pose.y, pose.theta) for pose in poses]).reshape(-1, 3)


def relative_poses(origin: FloatArray, poses: FloatArray) -> FloatArray:
    """Return ``T_origin_pose`` of poses (..., 3).

    They and ``origin`` are given in the same frame. There is one origin (3,) for all poses, or one for each.
    """
    out = np.asarray(poses - origin)
    dx, dy, c, s = out[..., 0].copy(), out[..., 1].copy(), np.cos(origin[..., 2]), np.sin(origin[..., 2])
    out[..., 0], out[..., 1], out[..., 2] = c * dx + s * dy, c * dy - s * dx, wrap_angles(out[..., 2])
    return out


def compose_poses(origin: FloatArray, poses: FloatArray) -> FloatArray:
    """Transform poses (..., 3), relative to ``origin``, to the frame of ``origin``: undoes relative_poses."""
    out = np.empty(np.broadcast_shapes(origin.shape, poses.shape))
    x, y, c, s = poses[..., 0], poses[..., 1], np.cos(origin[..., 2]), np.sin(origin[..., 2])
    out[..., 0], out[..., 1] = origin[..., 0] + c * x - s * y, origin[..., 1] + s * x + c * y
    out[..., 2] = wrap_angles(origin[..., 2] + poses[..., 2])
    return out


def inverse_poses(poses: FloatArray) -> FloatArray:
    """Return ``T_b_a`` of poses ``T_a_b``, (..., 3)."""
    return relative_poses(poses, np.zeros_like(poses))


def path_lengths(poses: FloatArray) -> FloatArray:
    """Return the path length from the first of these poses (K, 3), or points (K, 2), to each of them, metres; (K,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))])
