"""Faults of the wheel odometry. Each makes a new log of a log and one value; the scans stay as they were."""

from dataclasses import replace
from typing import Final

import numpy as np

from slam.files.logs import Log
from slam.lines.segments import IntArray
from slam.pose import FloatArray, Pose2D, relative_poses, stack_poses

_SLIP: Final = float(np.radians(10.0))
"""Jump of the heading where a wheel slips."""
_FIRST_SLIP: Final = 5
"""Scan before which no wheel slips: there is no map yet that could tell."""
_BLIND_AMONG: Final = 5
"""A silence strikes one of that many times as many of the greatest motions: one of a standing robot harms nobody."""


def jittering_wheels(log: Log, value: float, random: np.random.Generator) -> Log:
    """Add white noise of ``value`` metres to every place."""
    poses = log.T_odom_base.copy()
    poses[:, :2] += random.normal(0.0, value, (len(log), 2))
    return with_odometry(log, poses)


def misjudging_wheels(log: Log, value: float, random: np.random.Generator) -> Log:
    """Make the way longer by a share ``value``, and every turn longer or shorter by it: from one change of the turn's
    sign to the next a new choice."""
    moves = motions(log.T_odom_base)
    left = moves[:, 2] > 0.0
    turn = np.append(0, np.cumsum(left[1:] != left[:-1]))
    signs = random.choice([-1.0, 1.0], turn[-1] + 1)[turn]
    return with_motions(log, moves * np.column_stack([np.full((len(moves), 2), 1.0 + value), 1.0 + value * signs]))


def slipping_wheels(log: Log, value: float, random: np.random.Generator) -> Log:
    """Let the heading jump to one side at ``value`` scans."""
    moves = motions(log.T_odom_base)
    at = _some(np.arange(_FIRST_SLIP, len(moves)), value, random)
    moves[at, 2] += _SLIP * random.choice([-1.0, 1.0], len(at))
    return with_motions(log, moves)


def silent_wheels(log: Log, value: float, random: np.random.Generator) -> Log:
    """Lose ``value`` motions between two scans, as a hole in a log does."""
    moves = motions(log.T_odom_base)
    size = np.hypot(moves[:, 0], moves[:, 1]) + np.abs(moves[:, 2])
    greatest = np.argsort(-size)[: max(_BLIND_AMONG * int(value), 1)]
    moves[_some(greatest, value, random)] = 0.0
    return with_motions(log, moves)


def stale_wheels(log: Log, value: float, random: np.random.Generator) -> Log:
    """With probability ``value`` a scan has the odometry of the scan before it; the next makes it good."""
    late = np.flatnonzero(random.random(len(log)) < value)
    late = late[np.diff(late, prepend=-1) > 1]  # not the first scan, and never two in a row
    poses = log.T_odom_base.copy()
    poses[late] = poses[late - 1]
    return with_odometry(log, poses)


def motions(poses: FloatArray) -> FloatArray:
    """Motion (N - 1, 3) from every pose (N, 3) to the next, as seen from it."""
    return relative_poses(poses[:-1], poses[1:])


def with_motions(log: Log, moves: FloatArray) -> Log:
    """The log with an odometry of these motions (N - 1, 3)."""
    poses = [Pose2D()]
    for move in moves:
        poses.append(poses[-1] @ Pose2D.from_array(move))
    return with_odometry(log, stack_poses(poses))


def with_odometry(log: Log, poses: FloatArray) -> Log:
    """The log with this odometry (N, 3); the measured twists, which would contradict it, are left out."""
    return replace(log, T_odom_base=relative_poses(poses[0], poses), twists=None)


def _some(among: IntArray, count: float, random: np.random.Generator) -> IntArray:
    """So many of these, each once; all of them where they are fewer."""
    return random.choice(among, min(int(count), len(among)), replace=False)
