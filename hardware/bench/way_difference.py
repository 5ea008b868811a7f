"""How far two ways of a robot through the same scenario are apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray, wrap_angle

_STEP: Final = 0.1
"""Metres between two places that are compared."""
_SAMPLING: Final = 0.02
"""Metres: a robot that moves less from one pose to the next turns on the spot, and has no one heading there."""


@dataclass(frozen=True, slots=True)
class WayDifference:
    """Of two ways, each at the same distance driven: clocks that start at different times do not matter."""

    length: float
    """Metres that both drove."""
    largest: float
    """Between the places, metres ..."""
    rms: float
    """... and its root mean square."""
    heading: float
    """Between the headings, the largest, radians; turns on the spot, which have no length, left out."""

    @classmethod
    def between(cls, one: FloatArray, other: FloatArray, until: float = np.inf) -> Self:
        """Of two ways of poses x, y, theta, (N, 3) and (M, 3), up to ``until`` metres."""
        driven = [_driven(poses) for poses in (one, other)]
        length = min(driven[0][-1], driven[1][-1], until)
        at = np.arange(0.0, length, _STEP)
        a, b = (_poses_at(at, *way) for way in zip(driven, (one, other), strict=True))
        rolling = ~(_turning(at, driven[0]) | _turning(at, driven[1]))
        apart = np.hypot(*(a - b)[:, :2].T)
        turned = np.abs([wrap_angle(angle) for angle in (a - b)[rolling, 2]])
        return cls(length, apart.max(), float(np.sqrt(np.mean(apart**2))), turned.max(initial=0.0))


def _driven(poses: FloatArray) -> FloatArray:
    """Metres behind each pose, (N,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))])


def _poses_at(at: FloatArray, driven: FloatArray, poses: FloatArray) -> FloatArray:
    columns = [poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])]
    return np.column_stack([np.interp(at, driven, column) for column in columns])


def _turning(at: FloatArray, driven: FloatArray) -> NDArray[np.bool_]:
    """Which of these places are nearer than two steps to one where the robot hardly moved, (K,)."""
    standing = driven[:-1][np.diff(driven) < _SAMPLING]
    return np.abs(at[:, None] - np.append(standing, -np.inf)).min(axis=1) < 2.0 * _STEP  # type: ignore[no-any-return]
