"""Checks and converts the scans and the odometry that a caller passes one after another."""

import warnings
from typing import Any, Final

from hopslam.arguments import LidarTraits, checked_pose
from hopslam.scan import Scan
from slam.errors import InputError
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.scan import LaserScan

SCAN_TIME: Final = 0.1
"""Seconds from one scan to the next if no stamps are given."""
_FASTEST_TURN: Final = 6.5
"""Radians from one scan to the next; odometry that turns more is in degrees."""
_FARTHEST_MOVE: Final = 20.0
"""Metres from one scan to the next; odometry that moves more is in millimetres, or was reset."""


class Intake:
    """Checks each scan and its odometry, alone and against the previous one.

    Odometry and stamps come with every scan or with none.
    """

    def __init__(self, lidar: LidarTraits) -> None:
        self._lidar = lidar
        self._count = 0
        self._has_seen = False
        self._stamp: float | None = None  # of the last scan; None if the caller gives no stamps
        self._odometry: Pose2D | None = None  # with the last scan; None if the caller gives no odometry

    def take(
        self, ranges: Any, angles: Any = None, odometry: Any = None, stamp: Any = None
    ) -> tuple[LaserScan, Odometry, bool]:
        """Return the scan, the odometry at its stamp, and True if that was measured; InputError names the scan."""
        try:
            given = self._scan(ranges, angles, stamp)
            time = self._time(given)
            pose = None if odometry is None else checked_pose("odometry", odometry)
            self._check_all_or_none("odometry", odometry, self._odometry, "(x, y, theta)")
            twist = self._twist(pose, time)
        except InputError as error:
            raise InputError(f"scan {self._count}: {error}") from error
        self._count, self._odometry = self._count + 1, pose
        self._stamp = None if given.stamp is None else time
        self._warn_if_nothing_seen(given)
        scan = given.laser_scan(time)
        T_odom_base = (pose or Pose2D()) @ twist.motion(scan.stamp - time)  # a clockwise scan begins with its last beam
        return scan, Odometry(scan.stamp, T_odom_base, twist), pose is not None

    def _warn_if_nothing_seen(self, scan: Scan) -> None:
        """Warn as long as no scan has had a distance: the caller may have taken the wrong array."""
        self._has_seen = self._has_seen or bool(len(scan.points))
        if not self._has_seen:
            text = f"scan {self._count - 1}: none of its {len(scan)} ranges is from range_min to range_max, in metres"
            warnings.warn(f"{text}; the map begins with a scan that sees walls", stacklevel=4)

    def _scan(self, ranges: Any, angles: Any, stamp: Any) -> Scan:
        if isinstance(ranges, Scan):
            if angles is not None or stamp is not None:
                raise InputError("a Scan has angles and a stamp of its own; leave out angles and stamp")
            return ranges
        if angles is None:
            raise InputError("angles are missing; give the bearing of each beam in radians, or a hopslam.Scan")
        return Scan(ranges, angles, stamp, **self._lidar._asdict())

    def _time(self, scan: Scan) -> float:
        """Return the stamp that the caller gave, or a time at 10 Hz."""
        self._check_all_or_none("stamp", scan.stamp, self._stamp, "the seconds of its first beam")
        if scan.stamp is None:
            if scan.laser_scan().time_increment:
                raise InputError("stamp is missing; with a time_increment, give the seconds of each scan's first beam")
            return SCAN_TIME * self._count
        if self._stamp is not None and not scan.stamp > self._stamp:
            raise InputError(
                f"stamp is {scan.stamp!r}, not after {self._stamp!r} of the scan before; stamps are seconds and rise"
            )
        return scan.stamp

    def _check_all_or_none(self, name: str, given: Any, last: Any, what: str) -> None:
        if self._count and (given is None) != (last is None):
            fault = "missing, and was given before" if given is None else "given, and was not before"
            raise InputError(f"{name} is {fault}; give {what} with every scan or with none")

    def _twist(self, pose: Pose2D | None, time: float) -> Twist2D:
        """Return the velocity since the last scan; zero without odometry."""
        if pose is None:
            return Twist2D()
        last = self._odometry or pose
        motion = last.between(pose)
        if abs(pose.theta - last.theta) > _FASTEST_TURN or (self._odometry is None and abs(pose.theta) > _FASTEST_TURN):
            change = f"is {pose.theta:g}" if last is pose else f"goes from {last.theta:g} to {pose.theta:g} in one scan"
            raise InputError(f"odometry[2], theta, {change} and looks like degrees; give radians")
        if (distance := motion.distance(Pose2D())) > _FARTHEST_MOVE:
            raise InputError(
                f"odometry moves by {distance:g} in one scan; give metres: divide millimetres by 1000; "
                "if it was reset, begin a new Slam"
            )
        return Twist2D.from_motion(motion, 0.0 if self._stamp is None else time - self._stamp)
