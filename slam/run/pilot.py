"""Where to drive: way-points followed on the estimated pose."""

from __future__ import annotations

from math import cos
from typing import Protocol

from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.course import Course
from slam.scan import LaserScan
from slam.scenario.schema import Route

_TURN_GAIN = 1.5
"""Turning speed for each radian that the way-point lies off the heading, 1/s."""
_TURN_FIRST = 0.6
"""With the way-point farther off the heading than this, radians, the robot turns on the spot."""


class Pilot(Protocol):
    """Decides the next command."""

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D | None:
        """What to drive from this estimated pose and this scan; None when the route is done."""
        ...

    @property
    def progress(self) -> float:
        """Share of the route that is behind, 0 to 1."""
        ...


class WaypointPilot:
    """Drives a route's way-points one after another; without way-points it stands still and is never done."""

    def __init__(self, route: Route, start: Pose2D) -> None:
        self._route = route
        self._course = Course(start, route.waypoints, route.arrival)

    def command(self, T_map_base: Pose2D, scan: LaserScan | None = None) -> Twist2D | None:
        """What to drive from this estimated pose; None when the last way-point is reached."""
        if not self._route.waypoints:
            return Twist2D()
        self._course.advance(T_map_base)
        goal = self._course.goal
        return None if goal is None else self._towards(T_map_base.bearing(goal))

    @property
    def progress(self) -> float:
        """Share of the route that is behind, 0 to 1."""
        length = self._course.length
        return min(max(1.0 - self._course.left / length, 0.0), 1.0) if length else 0.0

    def _towards(self, bearing: float) -> Twist2D:
        limit = self._route.turn_speed
        angular = min(max(_TURN_GAIN * bearing, -limit), limit)
        linear = self._route.speed * cos(bearing) if abs(bearing) < _TURN_FIRST else 0.0
        return Twist2D(linear, angular)


class ReplayPilot:
    """Commands nothing: for a recorded log, which drives as it once did."""

    def __init__(self, scans: int) -> None:
        self._scans, self._seen = scans, 0

    @property
    def progress(self) -> float:
        """Share of the log's scans that were seen, 0 to 1."""
        return self._seen / self._scans

    def command(self, T_map_base: Pose2D, scan: LaserScan | None = None) -> Twist2D | None:
        """No motion, and never done: the log's end ends the run."""
        self._seen += 1
        return Twist2D()
