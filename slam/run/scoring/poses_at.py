"""A trajectory at times between its stamps."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray

MAX_GAP: Final = 10.0
"""Seconds to the nearest pose on both sides, at most, for a pose between two scans."""


class AtTimes(NamedTuple):
    """Poses (N, 3) at asked times, and whether there are any near enough, (N,)."""

    poses: FloatArray
    known: NDArray[np.bool_]


def poses_at(times: FloatArray, stamps: FloatArray, poses: FloatArray, max_gap: float = MAX_GAP) -> AtTimes:
    """The trajectory at these times, linear between its stamps, which must increase."""
    after = np.clip(np.searchsorted(stamps, times), 1, len(stamps) - 1)
    before_gap, after_gap = times - stamps[after - 1], stamps[after] - times
    inside = (before_gap >= 0) & (after_gap >= 0) & (before_gap <= max_gap) & (after_gap <= max_gap)
    known = inside | (np.minimum(np.abs(before_gap), np.abs(after_gap)) < 1e-3)
    columns = [poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])]
    return AtTimes(np.column_stack([np.interp(times, stamps, column) for column in columns]), known)
