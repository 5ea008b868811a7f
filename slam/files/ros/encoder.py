"""This project's values as ROS 2 messages, in CDR: https://docs.ros.org/en/humble/p/sensor_msgs, nav_msgs, tf2_msgs."""

from math import atan2, cos, inf, nextafter, sin
from typing import Any, Final

import numpy as np

from slam.files.ros.messages import LASER_SCAN, ODOMETRY, POSE, STAMPED_TWIST, TRANSFORMS, TWIST, ros2_types
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.scan import LaserScan

_LAST_SECOND: Final = 2**31 - 1
_NO_COVARIANCE: Final = np.zeros(36)
_NO_INTENSITIES: Final = np.empty(0, np.float32)


def nanoseconds(stamp: float) -> int:
    """Convert seconds to the whole nanoseconds of a ROS time, clipped to its limits, 1970 and 2038."""
    return round(1e9 * min(max(stamp, 0.0), float(_LAST_SECOND)))


def _half_turn(theta: float) -> tuple[float, float]:
    """Return sine and cosine of half an angle, adjusted in the last bit so that exactly this angle is read back."""
    s, c = sin(theta / 2.0), cos(theta / 2.0)
    near = ((a, b) for a in _neighbours(s) for b in _neighbours(c) if 2.0 * atan2(a, b) == theta)
    return next(near, (s, c))


def _neighbours(value: float) -> tuple[float, float, float]:
    return value, nextafter(value, inf), nextafter(value, -inf)


class Encoder:
    """Encodes values as messages. Poses lie in the plane, z = 0."""

    def __init__(self) -> None:
        self._store = ros2_types()
        self._types = self._store.types

    def scan(self, scan: LaserScan) -> bytes:
        """Encode ``sensor_msgs/LaserScan`` in frame ``laser``, in single precision."""
        ranges = np.asarray(scan.ranges, np.float32)
        return self._cdr(
            LASER_SCAN, self._header(scan.stamp, "laser"), scan.angle_min, scan.angle_max, scan.angle_increment,
            scan.time_increment, scan.scan_time, scan.range_min, scan.range_max, ranges, _NO_INTENSITIES,
        )  # fmt: skip

    def odometry(self, odometry: Odometry) -> bytes:
        """Encode ``nav_msgs/Odometry`` of ``base_link`` in ``odom``; its covariances are zero: not known."""
        twist, make = odometry.twist, self._make
        pose = make("geometry_msgs/msg/PoseWithCovariance", self._pose(odometry.T_odom_base), _NO_COVARIANCE)
        moving = make("geometry_msgs/msg/TwistWithCovariance", make(TWIST, *self._velocity(twist)), _NO_COVARIANCE)
        return self._cdr(ODOMETRY, self._header(odometry.stamp, "odom"), "base_link", pose, moving)

    def pose(self, stamp: float, frame: str, pose: Pose2D) -> bytes:
        """Encode ``geometry_msgs/PoseStamped``, the pose of ``base_link`` in that frame."""
        return self._cdr(POSE, self._header(stamp, frame), self._pose(pose))

    def twist(self, twist: Twist2D) -> bytes:
        """Encode ``geometry_msgs/Twist``."""
        return self._cdr(TWIST, *self._velocity(twist))

    def stamped_twist(self, stamp: float, twist: Twist2D) -> bytes:
        """Encode ``geometry_msgs/TwistStamped`` of ``base_link``."""
        return self._cdr(STAMPED_TWIST, self._header(stamp, "base_link"), self._make(TWIST, *self._velocity(twist)))

    def transforms(self, stamp: float, *transforms: tuple[str, str, Pose2D]) -> bytes:
        """Encode ``tf2_msgs/TFMessage`` of (frame, child frame, pose of the child)."""
        return self._cdr(TRANSFORMS, [self._transform(stamp, *transform) for transform in transforms])

    def definition(self, name: str) -> str:
        """Return the definition of a type and its parts in MCAP's schema encoding ``ros2msg``."""
        return self._store.generate_msgdef(name, ros_version=2)[0]

    def _transform(self, stamp: float, frame: str, child: str, pose: Pose2D) -> Any:
        turn = self._quaternion(pose.theta)
        placed = self._make("geometry_msgs/msg/Transform", self._vector(pose.x, pose.y), turn)
        return self._make("geometry_msgs/msg/TransformStamped", self._header(stamp, frame), child, placed)

    def _pose(self, pose: Pose2D) -> Any:
        point = self._make("geometry_msgs/msg/Point", pose.x, pose.y, 0.0)
        return self._make("geometry_msgs/msg/Pose", point, self._quaternion(pose.theta))

    def _quaternion(self, theta: float) -> Any:
        return self._make("geometry_msgs/msg/Quaternion", 0.0, 0.0, *_half_turn(theta))

    def _velocity(self, twist: Twist2D) -> tuple[Any, Any]:
        return self._vector(twist.linear), self._vector(0.0, 0.0, twist.angular)

    def _vector(self, x: float, y: float = 0.0, z: float = 0.0) -> Any:
        return self._make("geometry_msgs/msg/Vector3", x, y, z)

    def _header(self, stamp: float, frame: str) -> Any:
        return self._make("std_msgs/msg/Header", self._time(stamp), frame)

    def _time(self, stamp: float) -> Any:
        return self._make("builtin_interfaces/msg/Time", *divmod(nanoseconds(stamp), 10**9))

    def _make(self, name: str, *fields: Any) -> Any:
        return self._types[name](*fields)

    def _cdr(self, name: str, *fields: Any) -> bytes:
        return bytes(self._store.serialize_cdr(self._make(name, *fields), name))
