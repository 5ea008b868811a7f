"""Pilots decide where to drive: along way-points on the estimated pose, or at random by the scans alone."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import cos
from typing import Final, Protocol

import numpy as np

from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.scan import LaserScan
from slam.scenario.schema import Route
from slam.scenario.values import Point

_TURN_GAIN = 1.5
"""Turning speed per radian of heading error to the way-point, 1/s."""
_TURN_FIRST = 0.6
"""Heading error, radians, above which the robot turns on the spot."""
_WANDER_SPEED: Final = 0.5
"""Largest speed of a wandering robot, m/s."""
_WANDER_TURN_SPEED: Final = 0.8
"""Largest turning speed of a wandering robot, rad/s."""
_FREE_HALF_WIDTH: Final = 0.35
"""Half width that must be free ahead, metres."""
_STOP_DISTANCE: Final = 0.5
"""Distance of an obstacle ahead at which the robot begins to turn on the spot, metres."""
_GO_DISTANCE: Final = 0.9
"""Distance of an obstacle ahead at which it stops turning, metres."""


class RouteProgress:
    """Way-points that are passed in order; one is passed when the robot is within ``arrival`` metres of it."""

    def __init__(self, start: Pose2D, waypoints: Sequence[Point], arrival: float) -> None:
        self._arrival = arrival
        self._targets = [Pose2D(x, y) for x, y in waypoints]
        self._legs = [a.distance(b) for a, b in pairwise([start, *self._targets])]
        self._next = 0
        self.length = sum(self._legs)
        """Length of the whole route, metres."""
        self.remaining = self.length
        """Length from the last known position through all remaining way-points, metres; 0 at the end."""

    @property
    def goal(self) -> Pose2D | None:
        """The next way-point, map frame; None when all are passed, or if there are none."""
        return self._targets[self._next] if self._next < len(self._targets) else None

    @property
    def arrived(self) -> bool:
        """True if there are way-points, and all are passed."""
        return bool(self._targets) and self.goal is None

    def advance(self, T_map_base: Pose2D) -> None:
        """Update the robot's position, and pass the way-points that it has reached."""
        while (goal := self.goal) is not None:
            distance = T_map_base.distance(goal)
            self.remaining = distance + sum(self._legs[self._next + 1 :])
            if distance > self._arrival:
                return
            self._next += 1
        self.remaining = 0.0


class Pilot(Protocol):
    """Decides the next command."""

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D | None:
        """Return the command for this estimated pose and this scan; None when the route is done."""
        ...

    @property
    def progress(self) -> float:
        """Share of the route that is done, 0 to 1."""
        ...


class WaypointPilot:
    """Drives a route's way-points in order; without way-points it stands still and is never done."""

    def __init__(self, route: Route, start: Pose2D) -> None:
        self._route = route
        self._route_progress = RouteProgress(start, route.waypoints, route.arrival)

    def command(self, T_map_base: Pose2D, scan: LaserScan | None = None) -> Twist2D | None:
        """Return the command for this estimated pose; None when the last way-point is reached."""
        if not self._route.waypoints:
            return Twist2D()
        self._route_progress.advance(T_map_base)
        goal = self._route_progress.goal
        return None if goal is None else self._towards(T_map_base.bearing(goal))

    @property
    def progress(self) -> float:
        """Share of the route that is done, 0 to 1."""
        length = self._route_progress.length
        return min(max(1.0 - self._route_progress.remaining / length, 0.0), 1.0) if length else 0.0

    def _towards(self, bearing: float) -> Twist2D:
        limit = self._route.turn_speed
        angular = min(max(_TURN_GAIN * bearing, -limit), limit)
        linear = self._route.speed * cos(bearing) if abs(bearing) < _TURN_FIRST else 0.0
        return Twist2D(linear, angular)


class Passenger:
    """Commands nothing, and is never done: for a robot that others drive."""

    @property
    def progress(self) -> float:
        """0, as the length of the drive is unknown."""
        return 0.0

    def command(self, T_map_base: Pose2D, scan: LaserScan | None = None) -> Twist2D | None:
        """Return no motion."""
        return Twist2D()


class ReplayPilot(Passenger):
    """Pilot of a recorded log, which drives as recorded; the end of the log ends the run."""

    def __init__(self, scans: int) -> None:
        self._scans, self._seen = scans, 0

    @property
    def progress(self) -> float:
        """Share of the log's scans that were seen, 0 to 1."""
        return self._seen / self._scans

    def command(self, T_map_base: Pose2D, scan: LaserScan | None = None) -> Twist2D | None:
        """Return no motion, and count the scan."""
        self._seen += 1
        return Twist2D()


class Wanderer:
    """Drives where there is room, turns where there is none, and is never done; it does not use the pose."""

    progress = 0.0

    def __init__(self) -> None:
        self._turning = 0.0  # rad/s, while it turns on the spot

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D:
        """Return the command for this scan."""
        ahead, side = _room(scan)
        if ahead < (_GO_DISTANCE if self._turning else _STOP_DISTANCE):
            self._turning = self._turning or float(np.copysign(_WANDER_TURN_SPEED, side))
            return Twist2D(0.0, self._turning)
        self._turning = 0.0
        angular = float(np.clip(side, -_WANDER_TURN_SPEED, _WANDER_TURN_SPEED))
        return Twist2D(min(_WANDER_SPEED, ahead - 0.4 * _STOP_DISTANCE), angular)


def _room(scan: LaserScan) -> tuple[float, float]:
    """Return the free metres ahead, and the side with more room, from -1, all to the right, to 1, all to the left."""
    ranges = np.where(scan.echoes, scan.ranges, np.where(np.isposinf(scan.ranges), scan.range_max, np.inf))
    known, angles = np.isfinite(ranges), scan.bearings
    x, y = ranges[known] * np.cos(angles[known]), ranges[known] * np.sin(angles[known])
    ahead = x[(np.abs(y) < _FREE_HALF_WIDTH) & (x > 0.0)]
    front = np.abs(angles[known]) < 0.5 * np.pi
    side = float(y[front].sum() / max(np.abs(y[front]).sum(), 1e-9)) if front.any() else 0.0
    return float(ahead.min()) if len(ahead) else 0.0, side


class LocalizeThenDrive:
    """Wanders while the pose is unknown, and otherwise drives like another pilot."""

    def __init__(self, known: Callable[[], bool], then: Pilot) -> None:
        self._known, self._then, self._wanderer = known, then, Wanderer()

    @property
    def progress(self) -> float:
        """Progress of the other pilot."""
        return self._then.progress

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D | None:
        """Return the other pilot's command if the pose is known, else that of the wanderer."""
        return (self._then if self._known() else self._wanderer).command(T_map_base, scan)
