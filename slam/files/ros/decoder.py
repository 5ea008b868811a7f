"""Converts messages of ROS 1 and ROS 2 to this project's values; BadLine for invalid bytes."""

import struct
from math import atan2, hypot
from typing import Any, Final, NamedTuple

import numpy as np
from rosbags.serde import SerdeError

from slam.files.fields import LARGEST, BadLine, impossible
from slam.files.ros.decimals import decimal, decimal_ranges, exact_bearings, rounded_pose, rounded_stamp
from slam.files.ros.messages import STAMPED_TWIST, RawMessage, ros1_types, ros2_types
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D, wrap_angle
from slam.scan import LaserScan

_GARBLED: Final = (SerdeError, struct.error, ValueError, LookupError, AssertionError, OverflowError, MemoryError)


class Transform(NamedTuple):
    """A transform of ``tf2_msgs/TFMessage``, projected onto the plane."""

    stamp: float
    frame: str
    child: str
    pose: Pose2D
    """Pose of the child in the frame."""
    T_frame_child: FloatArray | None
    """The same pose in space, (4, 4), if the z axes differ."""
    received: float
    """Time at which it was recorded, seconds."""


class StampedPose(NamedTuple):
    """``geometry_msgs/PoseStamped``, projected onto the plane."""

    stamp: float
    frame: str
    pose: Pose2D


class StampedOdometry(NamedTuple):
    """``nav_msgs/Odometry``, projected onto the plane."""

    odometry: Odometry
    child: str
    """Name of the base frame."""
    received: float
    """Time at which it was recorded, seconds."""


def decode(raw: RawMessage) -> Any:
    """Decode the message with rosbags."""
    if raw.encoding not in ("cdr", "ros1"):
        raise BadLine(f"encoded as {raw.encoding or 'unknown'}")
    try:
        if raw.encoding == "ros1":
            return ros1_types().deserialize_ros1(raw.data, raw.type)
        return ros2_types().deserialize_cdr(raw.data, raw.type)
    except _GARBLED:
        raise BadLine("truncated") from None


def decode_scan(raw: RawMessage) -> LaserScan:
    """Decode a ``sensor_msgs/LaserScan``."""
    message = decode(raw)
    angle_min, angle_increment = exact_bearings(message.angle_min, message.angle_increment)
    return LaserScan(
        stamp=seconds(message.header),
        angle_min=angle_min,
        angle_increment=angle_increment,
        range_min=decimal(message.range_min),
        range_max=decimal(message.range_max),
        ranges=decimal_ranges(message.ranges),
        time_increment=decimal(message.time_increment),
        scan_time=decimal(message.scan_time),
    )


def decode_odometry(raw: RawMessage) -> StampedOdometry:
    """Decode a ``nav_msgs/Odometry``."""
    message = decode(raw)
    pose, twist = message.pose.pose, message.twist.twist
    moving = Twist2D(twist.linear.x, twist.angular.z)
    odometry = Odometry(seconds(message.header), _planar(pose.position, pose.orientation), moving)
    return StampedOdometry(odometry, frame_name(message.child_frame_id), 1e-9 * raw.time)


def decode_pose(raw: RawMessage) -> StampedPose:
    """Decode a ``geometry_msgs/PoseStamped``."""
    message = decode(raw)
    pose = _planar(message.pose.position, message.pose.orientation)
    return StampedPose(seconds(message.header), frame_name(message.header.frame_id), pose)


def decode_twist(raw: RawMessage) -> Twist2D:
    """Return the speeds forward and about z of a ``geometry_msgs/Twist`` or ``TwistStamped``."""
    message = decode(raw)
    twist = message.twist if raw.type == STAMPED_TWIST else message
    for name, value in (("linear.x", twist.linear.x), ("angular.z", twist.angular.z)):
        if not abs(value) <= LARGEST:
            raise impossible(name, value)
    return Twist2D(twist.linear.x, twist.angular.z)


def decode_unsure_pose(raw: RawMessage) -> StampedPose:
    """Decode a ``geometry_msgs/PoseWithCovarianceStamped``, without its covariance."""
    message = decode(raw)
    pose = _planar(message.pose.pose.position, message.pose.pose.orientation)
    return StampedPose(seconds(message.header), frame_name(message.header.frame_id), pose)


def decode_transforms(raw: RawMessage) -> list[Transform]:
    """Return the transforms in a ``tf2_msgs/TFMessage``."""
    return [_transform(placed, 1e-9 * raw.time) for placed in decode(raw).transforms]


def seconds(header: Any) -> float:
    """Return the stamp of a message."""
    return rounded_stamp(float(header.stamp.sec) + 1e-9 * float(header.stamp.nanosec))


def frame_name(name: str) -> str:
    """Return the name without the leading slash of old ROS 1 versions."""
    return name.lstrip("/")


def _transform(placed: Any, received: float) -> Transform:
    q = placed.transform.rotation
    frame, child = frame_name(placed.header.frame_id), frame_name(placed.child_frame_id)
    place = placed.transform.translation
    in_space = None if q.x == q.y == 0.0 else _in_space(place, q)
    return Transform(seconds(placed.header), frame, child, _planar(place, q), in_space, received)


def _in_space(place: Any, q: Any) -> FloatArray:
    """Return the pose as a matrix (4, 4); BadLine if it is invalid."""
    if not abs(place.z) <= LARGEST:
        raise impossible("z", place.z)
    x, y, z, w = np.array([q.x, q.y, q.z, q.w]) / hypot(q.x, q.y, q.z, q.w)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y), place.x],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x), place.y],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y), place.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def _planar(point: Any, q: Any) -> Pose2D:
    """Project a pose onto the plane: its heading is that of the x axis. The result is exact for a level pose."""
    for name, value in {"x": point.x, "y": point.y, "qx": q.x, "qy": q.y, "qz": q.z, "qw": q.w}.items():
        if not abs(value) <= LARGEST:
            raise impossible(name, value)
    if q.x == q.y == 0.0:
        return rounded_pose(Pose2D(point.x, point.y, wrap_angle(2.0 * atan2(q.z, q.w))))
    return Pose2D(point.x, point.y, atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z)))
