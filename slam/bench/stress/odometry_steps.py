"""Odometry as steps from scan to scan, and steps made into odometry; rows x, y, theta, metres and radians."""

from itertools import accumulate
from typing import Final

import numpy as np

from slam.pose import FloatArray, Pose2D, relative_poses, stack_poses
from slam.run.scoring.pose_errors import Trajectory, poses_at

BACKWARDS: Final = 0.05
"""Metres that the reference must move backwards in three steps to count as driving backwards."""


def steps(poses: FloatArray) -> FloatArray:
    """Return the steps (N - 1, 3) between these poses (N, 3)."""
    return relative_poses(poses[:-1], poses[1:])


def chained(start: FloatArray, moved: FloatArray) -> FloatArray:
    """Return the poses (N, 3) after these steps (N - 1, 3) from ``start`` (3,)."""
    motions = (Pose2D.from_array(step) for step in moved)
    return stack_poses(accumulate(motions, Pose2D.__matmul__, initial=Pose2D.from_array(start)))


def size_of_steps(moved: FloatArray) -> FloatArray:
    """Return the size of each step, the sum of metres and radians, (N,)."""
    return np.asarray(np.hypot(moved[:, 0], moved[:, 1]) + np.abs(moved[:, 2]))


def with_signs(stamps: FloatArray, odometry: FloatArray, reference: Trajectory) -> FloatArray:
    """Return the odometry (N, 3), with steps reversed if they go forwards and the reference goes backwards.

    The wheel encoders of some robots lose the sign of a backward motion. The reference is taken over three steps, as it
    is not smooth.
    """
    known = poses_at(stamps, *reference, np.inf).poses
    n = len(known) - 1
    before, after = np.maximum(np.arange(n) - 1, 0), np.minimum(np.arange(n) + 2, n)
    along, moved = relative_poses(known[before], known[after])[:, 0], steps(odometry)
    moved[(along < -BACKWARDS) & (moved[:, 0] > 0.0), :2] *= -1.0
    return chained(odometry[0], moved)
