"""How good a trajectory is: the field's usual measures, as evo and the tools of the relations benchmark have them.

Poses are rows x, y, theta (N, 3), metres and radians.
"""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.deskew import deskewed
from slam.pose import FloatArray, Pose2D
from slam.run.logs import Log
from slam.run.logs.log import relative_poses

MAX_GAP: Final = 10.0
"""Seconds to the nearest pose on both sides, at most, for a pose between two scans."""
CELL: Final = 0.05
"""Metres: the cells of the crispness."""


class AtTimes(NamedTuple):
    """Poses at asked times, and whether there are any near enough."""

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


def aligned(poses: FloatArray, onto: FloatArray) -> FloatArray:
    """The poses moved rigidly so that their places fit best, by least squares."""
    a, b = poses[:, :2].mean(axis=0), onto[:, :2].mean(axis=0)
    H = (poses[:, :2] - a).T @ (onto[:, :2] - b)
    turn = np.arctan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1])
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([(poses[:, :2] - a) @ np.array([[c, s], [-s, c]]) + b, poses[:, 2] + turn])


def absolute_error(poses: FloatArray, truth: FloatArray) -> float:
    """ATE: root mean square of the distances after alignment, metres."""
    return float(np.sqrt(np.mean(np.sum((aligned(poses, truth) - truth)[:, :2] ** 2, axis=1))))


def relative_error(poses: FloatArray, truth: FloatArray, length: float = 10.0) -> float:
    """RPE: root mean square of the translation error over all pieces of this length of the true path, metres."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(truth[:, :2], axis=0).T))])
    last = np.searchsorted(way, way + length)
    first = np.flatnonzero(last < len(way))
    first = first[way[last[first]] - way[first] < 2 * length + 1]
    last = last[first]
    errors = relative_poses(relative_poses(truth[first], truth[last]), relative_poses(poses[first], poses[last]))
    return float(np.sqrt(np.mean(np.sum(errors[:, :2] ** 2, axis=1)))) if len(first) else np.nan


class Relations(NamedTuple):
    """Errors against relations known by hand: Kuemmerle et al., Autonomous Robots 27, 2009."""

    metres: FloatArray
    radians: FloatArray


def relation_errors(path: Path, stamps: FloatArray, poses: FloatArray) -> Relations:
    """Of every relation (lines t1 t2 x y z roll pitch yaw) whose two times the trajectory covers."""
    with gzip.open(path, "rt") as file:
        table = np.loadtxt(file)
    first, second = (poses_at(table[:, column], stamps, poses) for column in (0, 1))
    errors = relative_poses(table[:, [2, 3, 7]], relative_poses(first.poses, second.poses))[first.known & second.known]
    return Relations(np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2]))


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
    T_map_laser = Pose2D(*pose.tolist()) @ log.T_base_laser
    return T_map_laser.transform(np.column_stack([r * np.cos(bearings), r * np.sin(bearings)]))
