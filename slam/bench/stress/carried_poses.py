"""Estimates at times between the scans of a thinned log, carried there by its unspoilt odometry."""

import numpy as np

from slam.pose import FloatArray, Pose2D, relative_poses, stack_poses, wrap_angles
from slam.run.scoring.pose_errors import InterpolatedPoses, poses_at


def carried_poses(
    times: FloatArray, stamps: FloatArray, poses: FloatArray, dense_stamps: FloatArray, odometry: FloatArray
) -> InterpolatedPoses:
    """The trajectory ``poses`` (N, 3) at these times: carried from the scans before and after each by the odometry at
    the dense stamps, the nearer one counting for more. Known within the stamps of the trajectory."""
    after = np.clip(np.searchsorted(stamps, times), 1, len(stamps) - 1)
    at_times, at_scans = (poses_at(at, dense_stamps, odometry).poses for at in (times, stamps))
    first, second = (_composed(poses[scan], relative_poses(at_scans[scan], at_times)) for scan in (after - 1, after))
    share = np.clip((times - stamps[after - 1]) / (stamps[after] - stamps[after - 1]), 0.0, 1.0)
    turn = wrap_angles(second[:, 2] - first[:, 2])
    between = first + share[:, None] * np.column_stack([second[:, :2] - first[:, :2], turn])
    return InterpolatedPoses(between, (times >= stamps[0]) & (times <= stamps[-1]))


def _composed(poses: FloatArray, motions: FloatArray) -> FloatArray:
    return stack_poses(Pose2D.from_array(a) @ Pose2D.from_array(b) for a, b in zip(poses, motions, strict=True))
