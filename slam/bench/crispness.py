"""How crisp a map a trajectory makes."""

from __future__ import annotations

from typing import Final

import numpy as np

from slam.deskew import deskewed
from slam.files.logs import Log
from slam.pose import FloatArray, Pose2D

CELL: Final = 0.05
"""Metres: the cells of the crispness."""


def crispness(log: Log, poses: FloatArray, cut: int, reach: float, deskew: bool) -> float:
    """Occupied cells of 5 cm for every 1000 points, every scan drawn at its pose, deskewed or as it was taken; the
    first and last ``cut`` beams and ranges of ``reach`` metres and more are left out."""
    drawn = np.concatenate([end_points(log, k, poses[k], cut, reach, deskew) for k in range(len(log))])
    return 1000.0 * len(np.unique(drawn // CELL, axis=0)) / max(len(drawn), 1)


def end_points(log: Log, index: int, pose: FloatArray, cut: int, reach: float, deskew: bool) -> FloatArray:
    """Where the beams of one scan ended, (M, 2), metres in the frame of the poses of the base."""
    scan = log.scan(index)
    if deskew:
        scan = deskewed(scan, log.odometry(index).twist, log.T_base_laser)
    used = np.isfinite(scan.ranges) & (scan.ranges > 0.0) & (scan.ranges < reach)
    used[:cut] = used[len(used) - cut :] = False
    r, bearings = scan.ranges[used], scan.bearings[used]
    T_map_laser = Pose2D.from_array(pose) @ log.T_base_laser
    return T_map_laser.transform(np.column_stack([r * np.cos(bearings), r * np.sin(bearings)]))
