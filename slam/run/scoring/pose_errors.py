"""Errors of a trajectory: absolute and relative, against a reference or against relations.

For the errors against a reference see Sturm et al., IROS 2012; for relations, measured by hand, see Kuemmerle et al.,
Autonomous Robots 27, 2009.

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
"""Largest time from an interpolated pose to the nearest poses on both sides, seconds."""
_RELATION: Final = "t1 t2 x y z roll pitch yaw"


class Trajectory(NamedTuple):
    """Stamps (N,), seconds, and poses (N, 3), metres and radians."""

    stamps: FloatArray
    poses: FloatArray


class InterpolatedPoses(NamedTuple):
    """Poses (N, 3) at requested times, and True where there are poses near enough, (N,)."""

    poses: FloatArray
    known: NDArray[np.bool_]


def poses_at(times: FloatArray, stamps: FloatArray, poses: FloatArray, max_gap: float = MAX_GAP) -> InterpolatedPoses:
    """Interpolate the trajectory at these times, linearly between its stamps, which must increase."""
    after = np.clip(np.searchsorted(stamps, times), 1, len(stamps) - 1)
    before_gap, after_gap = times - stamps[after - 1], stamps[after] - times
    inside = (before_gap >= 0) & (after_gap >= 0) & (before_gap <= max_gap) & (after_gap <= max_gap)
    known = inside | (np.minimum(np.abs(before_gap), np.abs(after_gap)) < 1e-3)
    columns = [poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])]
    return InterpolatedPoses(np.column_stack([np.interp(times, stamps, column) for column in columns]), known)


def carried_poses(times: FloatArray, trajectory: Trajectory, odometry: Trajectory) -> InterpolatedPoses:
    """Continue the trajectory by odometry to these times, forward from the pose before and back from the pose after.

    The two results are weighted linearly in time. It is for poses that are far apart, where a straight line would cut
    corners.
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
    """Absolute errors, (K,) each."""

    metres: FloatArray
    radians: FloatArray


def rmse(errors: FloatArray) -> float:
    """Return the root mean square; nan for none."""
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else float("nan")


def aligned(poses: FloatArray, onto: FloatArray) -> FloatArray:
    """Align the poses rigidly with ``onto``, by least squares of their positions."""
    a, b = poses[:, :2].mean(axis=0), onto[:, :2].mean(axis=0)
    H = (poses[:, :2] - a).T @ (onto[:, :2] - b)
    turn = np.arctan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1])
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([(poses[:, :2] - a) @ np.array([[c, s], [-s, c]]) + b, poses[:, 2] + turn])


def absolute_errors(poses: FloatArray, truth: FloatArray, align: bool = True) -> PoseErrors:
    """Return the errors of every pose, with or without a rigid alignment."""
    moved = aligned(poses, truth) if align else poses
    return _sizes(relative_poses(truth, moved))


def absolute_error(poses: FloatArray, truth: FloatArray) -> float:
    """Return the ATE: root mean square of the distances after alignment, metres."""
    return rmse(absolute_errors(poses, truth).metres)


def errors_by_path(poses: FloatArray, truth: FloatArray, length: float) -> PoseErrors:
    """Return the errors of the motions over all pieces of this length, metres, of the true path."""
    distances = path_lengths(truth)
    last = np.searchsorted(distances, distances + length)
    first = np.flatnonzero(last < len(distances))
    first = first[distances[last[first]] - distances[first] < 2 * length + 1]
    return _motion_errors(poses, truth, first, last[first])


def errors_by_frames(poses: FloatArray, truth: FloatArray, frames: int) -> PoseErrors:
    """Return the errors of the motions from every pose to the one ``frames`` later."""
    first = np.arange(max(len(poses) - frames, 0))
    return _motion_errors(poses, truth, first, first + frames)


def relative_error(poses: FloatArray, truth: FloatArray, length: float = 10.0) -> float:
    """Return the RPE: root mean square of the translation error over all pieces of this length of the path, metres."""
    return rmse(errors_by_path(poses, truth, length).metres)


def read_relations(path: Path) -> FloatArray:
    """Read rows t1, t2, x, y, yaw, seconds, metres and radians, from a file of relations.

    Its lines are ``t1 t2 x y z roll pitch yaw``, plain or gzip. LogError, with the line, for any other line.
    """
    with closing(read_lines(path)) as lines:
        rows = [
            table_row(words, _RELATION, f"{path}: line {number}") for number, line in lines if (words := line.split())
        ]
    if not rows:
        raise LogError(f"{path}: no relation in this file; need lines of {_RELATION}")
    return np.array(rows)[:, [0, 1, 2, 3, 7]]


def relation_errors(relations: FloatArray, stamps: FloatArray, poses: FloatArray, gap: float = MAX_GAP) -> PoseErrors:
    """Return the errors of every relation whose two times the trajectory covers."""
    return errors_between(relations, *(poses_at(relations[:, column], stamps, poses, gap) for column in (0, 1)))


def errors_between(relations: FloatArray, first: InterpolatedPoses, second: InterpolatedPoses) -> PoseErrors:
    """Return the errors of the relations whose two poses are known."""
    errors = relative_poses(relations[:, 2:], relative_poses(first.poses, second.poses))[first.known & second.known]
    return _sizes(errors)


def _motion_errors(poses: FloatArray, truth: FloatArray, first: IntArray, last: IntArray) -> PoseErrors:
    true, found = relative_poses(truth[first], truth[last]), relative_poses(poses[first], poses[last])
    return _sizes(relative_poses(true, found))


def _sizes(errors: FloatArray) -> PoseErrors:
    return PoseErrors(np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2]))
