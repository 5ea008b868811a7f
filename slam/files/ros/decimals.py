"""Numbers of messages as the decimals that they stand for.

A message has ranges in single precision, stamps in nanoseconds and headings as quaternions. Runs use the same decimals,
so that the replay of a recorded run gets the same numbers, to the last bit.
"""

from dataclasses import replace
from typing import Any, Final

import numpy as np

from slam.lidars import whole_steps
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation

_FAR: Final = 16.0
"""Metres from which single precision is coarser than a micrometre."""


def as_recorded(observation: Observation) -> Observation:
    """Return the observation with the numbers that a log of it has."""
    scan, odometry = observation.scan, observation.odometry
    angle_min, angle_increment = exact_bearings(scan.angle_min, scan.angle_increment)
    scan = replace(
        scan,
        stamp=rounded_stamp(scan.stamp),
        angle_min=angle_min,
        angle_increment=angle_increment,
        ranges=decimal_ranges(np.asarray(scan.ranges, np.float32)),
        time_increment=decimal(scan.time_increment),
    )
    pose = rounded_pose(odometry.T_odom_base)
    odometry = replace(odometry, stamp=rounded_stamp(odometry.stamp), T_odom_base=pose)
    return replace(observation, scan=scan, odometry=odometry)


def decimal_ranges(ranges: Any) -> FloatArray:
    """Convert ranges in single precision to the decimals that they stand for.

    For a lidar that reports whole micrometres or millimetres, the result is exact.
    """
    with np.errstate(invalid="ignore"):  # at the nan of a damaged message
        exact: FloatArray = ranges.astype(np.float64)
    rounded: FloatArray = np.where(np.abs(exact) < _FAR, np.round(exact, 6), np.round(exact, 4))
    return rounded


def exact_bearings(angle_min: float, angle_increment: float) -> tuple[float, float]:
    """Return the values that a bearing and a step in single precision stand for: whole steps of a turn, or decimals."""
    return whole_steps(angle_min, angle_increment) or (decimal(angle_min), decimal(angle_increment))


def decimal(value: float) -> float:
    """Return the short decimal that a number in single precision stands for."""
    return float(str(np.float32(value)))


def rounded_stamp(seconds: float) -> float:
    """Return the stamp in whole nanoseconds."""
    return round(seconds, 9)


def rounded_pose(pose: Pose2D) -> Pose2D:
    """Return the pose in whole picometres and picoradians, which a quaternion and a sum of poses preserve."""
    return Pose2D(round(pose.x, 12), round(pose.y, 12), round(pose.theta, 12))
