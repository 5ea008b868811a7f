"""Errors of a trajectory: absolute and relative, against a reference or against relations.

For the first see Sturm et al., IROS 2012; for the second, known by hand, Kuemmerle et al., Autonomous Robots 27, 2009.

Poses are rows x, y, theta (N, 3), metres and radians.
"""

from contextlib import closing
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.errors import LogError
from slam.files.fields import table_row
from slam.files.text_lines import read_lines
from slam.lines.segments import IntArray
from slam.pose import FloatArray, compose_poses, path_lengths, relative_poses, wrap_angles

MAX_GAP: Final = 10.0
"""Seconds to the nearest pose on both sides, at most, for a pose between two scans."""
_RELATION: Final = "t1 t2 x y z roll pitch yaw"


class Trajectory(NamedTuple):
    """Stamps (N,), seconds, and poses (N, 3), metres and radians."""

    stamps: FloatArray
    poses: FloatArray


class InterpolatedPoses(NamedTuple):
    """Poses (N, 3) at asked times, and whether there are any near enough, (N,)."""

    poses: FloatArray
    known: NDArray[np.bool_]


def poses_at(times: FloatArray, stamps: FloatArray, poses: FloatArray, max_gap: float = MAX_GAP) -> InterpolatedPoses:
    """The trajectory at these times, linear between its stamps, which must increase."""
    after = np.clip(np.searchsorted(stamps, times), 1, len(stamps) - 1)
    before_gap, after_gap = times - stamps[after - 1], stamps[after] - times
    inside = (before_gap >= 0) & (after_gap >= 0) & (before_gap <= max_gap) & (after_gap <= max_gap)
    known = inside | (np.minimum(np.abs(before_gap), np.abs(after_gap)) < 1e-3)
    columns = [poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])]
    return InterpolatedPoses(np.column_stack([np.interp(times, stamps, column) for column in columns]), known)


def carried_poses(times: FloatArray, trajectory: Trajectory, odometry: Trajectory) -> InterpolatedPoses:
    """The trajectory at these times, carried there by the odometry from the pose before and from the pose after.

    Between the two it is in proportion. It is for poses that are far apart, where a straight line would cut corners.
    """
    stamps, poses = trajectory
    known = (times >= stamps[0]) & (times <= stamps[-1])
    after = np.clip(np.searchsorted(stamps, times), 1, len(stamps) - 1)
    wheels = poses_at(times, *odometry, np.inf).poses
    wheels_then = poses_at(stamps, *odometry, np.inf).poses
    begin, end = (compose_poses(poses[k], relative_poses(wheels_then[k], wheels)) for k in (after - 1, after))
    share = np.clip((times - stamps[after - 1]) / (stamps[after] - stamps[after - 1]), 0.0, 1.0)
    difference = end - begin
    difference[:, 2] = wrap_angles(difference[:, 2])
    return InterpolatedPoses(begin + share[:, None] * difference, known)


class PoseErrors(NamedTuple):
    """Sizes of errors, (K,) each."""

    metres: FloatArray
    radians: FloatArray


def rmse(errors: FloatArray) -> float:
    """Root mean square; nan of none."""
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else float("nan")


def aligned(poses: FloatArray, onto: FloatArray) -> FloatArray:
    """The poses moved rigidly so that their places fit best, by least squares."""
    a, b = poses[:, :2].mean(axis=0), onto[:, :2].mean(axis=0)
    H = (poses[:, :2] - a).T @ (onto[:, :2] - b)
    turn = np.arctan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1])
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([(poses[:, :2] - a) @ np.array([[c, s], [-s, c]]) + b, poses[:, 2] + turn])


def absolute_errors(poses: FloatArray, truth: FloatArray, align: bool = True) -> PoseErrors:
    """Errors of every pose, after a rigid alignment or as it stands."""
    moved = aligned(poses, truth) if align else poses
    return _sizes(relative_poses(truth, moved))


def absolute_error(poses: FloatArray, truth: FloatArray) -> float:
    """ATE: root mean square of the distances after alignment, metres."""
    return rmse(absolute_errors(poses, truth).metres)


def errors_by_path(poses: FloatArray, truth: FloatArray, length: float) -> PoseErrors:
    """Errors of the motions over all pieces of this length, metres, of the true path."""
    way = path_lengths(truth)
    last = np.searchsorted(way, way + length)
    first = np.flatnonzero(last < len(way))
    first = first[way[last[first]] - way[first] < 2 * length + 1]
    return _motion_errors(poses, truth, first, last[first])


def errors_by_frames(poses: FloatArray, truth: FloatArray, frames: int) -> PoseErrors:
    """Errors of the motions from every pose to the one that many later."""
    first = np.arange(max(len(poses) - frames, 0))
    return _motion_errors(poses, truth, first, first + frames)


def relative_error(poses: FloatArray, truth: FloatArray, length: float = 10.0) -> float:
    """RPE: root mean square of the translation error over all pieces of this length of the true path, metres."""
    return rmse(errors_by_path(poses, truth, length).metres)


def read_relations(path: Path) -> FloatArray:
    """Rows t1, t2, x, y, yaw, seconds, metres and radians, of a file of relations.

    Its lines are ``t1 t2 x y z roll pitch yaw``, plain or gzip. LogError, naming the line, for another one.
    """
    with closing(read_lines(path)) as lines:
        rows = [
            table_row(words, _RELATION, f"{path}: line {number}") for number, line in lines if (words := line.split())
        ]
    if not rows:
        raise LogError(f"{path}: no relation in this file; need lines of {_RELATION}")
    return np.array(rows)[:, [0, 1, 2, 3, 7]]


def relation_errors(relations: FloatArray, stamps: FloatArray, poses: FloatArray, gap: float = MAX_GAP) -> PoseErrors:
    """Errors of every relation whose two times the trajectory covers."""
    return errors_between(relations, *(poses_at(relations[:, column], stamps, poses, gap) for column in (0, 1)))


def errors_between(relations: FloatArray, first: InterpolatedPoses, second: InterpolatedPoses) -> PoseErrors:
    """Errors of those relations both of whose poses are known."""
    errors = relative_poses(relations[:, 2:], relative_poses(first.poses, second.poses))[first.known & second.known]
    return _sizes(errors)


def _motion_errors(poses: FloatArray, truth: FloatArray, first: IntArray, last: IntArray) -> PoseErrors:
    true, found = relative_poses(truth[first], truth[last]), relative_poses(poses[first], poses[last])
    return _sizes(relative_poses(true, found))


def _sizes(errors: FloatArray) -> PoseErrors:
    return PoseErrors(np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2]))
