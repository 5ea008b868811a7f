"""The lidar of a robot, from its first scan and its transforms."""

import logging
import time
from dataclasses import dataclass, replace
from math import hypot
from typing import Final, Self

from slam.errors import RobotError
from slam.files.fields import BadLine
from slam.files.logs.bag_poses import Mount
from slam.files.logs.bag_scans import BagScan, parse_laser_scan, whole_scan
from slam.files.ros.messages import RawMessage
from slam.lidars import Lidar
from slam.pose import Pose2D
from slam.run.ros_robot.heard_topics import HeardTopics
from slam.scan import LaserScan

_LOG: Final = logging.getLogger("hopslam.ros")
_LOOK: Final = 0.1
"""Seconds between two checks for a scan."""
_TRANSFORM: Final = 2.0
"""Seconds to wait for the transform to the lidar."""
_SAME_PLACE, _SAME_HEADING = 0.01, 0.02
"""Largest difference, metres and radians, between the mount in the scenario and that of the transforms."""
_PERIOD: Final = 0.1
"""Scan period, seconds, if the lidar does not report it."""


@dataclass(frozen=True, slots=True)
class HeardLidar:
    """The lidar of the first scan; scans of other lidars are skipped."""

    frame: str
    lidar: Lidar
    mount: Mount | None
    """Mount on the base; None if no transform gives it."""

    @classmethod
    def wait_for(cls, topics: HeardTopics, until: float) -> Self | None:
        """Return the lidar of the first scan, without consuming that scan; None if none comes in time."""
        while time.monotonic() < until:
            raw = topics.next_scan(min(until, time.monotonic() + _LOOK))
            if raw is not None and (scan := _parsed(raw)) is not None:
                mount = topics.mount(scan.frame, time.monotonic() + _TRANSFORM)
                topics.put_back(raw)
                _, lidar = scan.upright(mount is not None and mount.inverted)
                return cls(scan.frame, replace(lidar, scan_time=scan.scan_time or _PERIOD), mount)
        return None

    def read(self, raw: RawMessage) -> LaserScan | None:
        """Return the scan in a message; None if it is garbled, or of another lidar."""
        parsed = _parsed(raw)
        if parsed is None or parsed.frame != self.frame:
            return None
        scan = whole_scan(raw, parsed, self.mount is not None and self.mount.inverted)
        return scan if scan.scan_time > 0.0 else replace(scan, scan_time=self.lidar.scan_time)

    def place(self, otherwise: Pose2D) -> Pose2D:
        """Return ``T_base_laser``; ``otherwise``, with a warning, if no transform gives it."""
        if self.mount is not None:
            return self.mount.T_base_laser
        x, y, theta = otherwise.x, otherwise.y, otherwise.theta
        _LOG.warning(
            "no transform to %s: it is taken to sit at x=%g y=%g theta=%g of the base", self.frame, x, y, theta
        )
        return otherwise

    def require_place(self, expected: Pose2D) -> None:
        """Raise RobotError if the lidar's mount differs from that of the scenario."""
        place = self.place(expected)
        off = expected.between(place)
        if hypot(off.x, off.y) > _SAME_PLACE or abs(off.theta) > _SAME_HEADING:
            settings = f"lidar.mount.x={place.x:g} lidar.mount.y={place.y:g} lidar.mount.theta={place.theta:g}"
            raise RobotError(f"{self.frame} does not sit where the scenario has the lidar; set {settings}")


def _parsed(raw: RawMessage) -> BagScan | None:
    try:
        return parse_laser_scan(raw, 0)
    except BadLine as fault:
        _LOG.debug("%s: ignored a scan that cannot be used: %s", raw.topic, fault)
        return None
