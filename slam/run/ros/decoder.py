"""ROS 2 messages in CDR as this project's values."""

from __future__ import annotations

from math import atan2
from typing import Any

import numpy as np

from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.run.ros.encoder import typestore
from slam.run.ros.topics import LASER_SCAN, ODOMETRY, POSE, TRANSFORMS
from slam.scan import LaserScan


def decode_scan(data: bytes) -> LaserScan:
    """``sensor_msgs/LaserScan``."""
    message = _message(data, LASER_SCAN)
    return LaserScan(
        stamp=_stamp(message.header),
        angle_min=message.angle_min,
        angle_increment=message.angle_increment,
        range_min=message.range_min,
        range_max=message.range_max,
        ranges=message.ranges.astype(np.float64),
        time_increment=message.time_increment,
        scan_time=message.scan_time,
    )


def decode_odometry(data: bytes) -> Odometry:
    """``nav_msgs/Odometry``, seen from above."""
    message = _message(data, ODOMETRY)
    twist = message.twist.twist
    return Odometry(_stamp(message.header), _pose(message.pose.pose), Twist2D(twist.linear.x, twist.angular.z))


def decode_pose(data: bytes) -> Pose2D:
    """``geometry_msgs/PoseStamped``, seen from above."""
    return _pose(_message(data, POSE).pose)


def decode_transforms(data: bytes) -> list[tuple[float, str, str, Pose2D]]:
    """Stamp, frame, child frame and the pose of the child, of each transform of a ``tf2_msgs/TFMessage``."""
    return [
        (
            _stamp(placed.header),
            placed.header.frame_id.lstrip("/"),
            placed.child_frame_id.lstrip("/"),
            _planar(placed.transform.translation, placed.transform.rotation),
        )
        for placed in _message(data, TRANSFORMS).transforms
    ]


def _message(data: bytes, name: str) -> Any:
    return typestore().deserialize_cdr(data, name)


def _stamp(header: Any) -> float:
    return float(round(header.stamp.sec + 1e-9 * header.stamp.nanosec, 9))


def _pose(pose: Any) -> Pose2D:
    return _planar(pose.position, pose.orientation)


def _planar(point: Any, q: Any) -> Pose2D:
    """Heading: where the x axis points, seen from above."""
    return Pose2D(point.x, point.y, atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z)))
