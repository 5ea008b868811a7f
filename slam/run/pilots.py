"""Pilots decide where to drive: along way-points on the estimated pose, or about on the scans alone."""

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
"""Turning speed for each radian that the way-point lies off the heading, 1/s."""
_TURN_FIRST = 0.6
"""With the way-point farther off the heading than this, radians, the robot turns on the spot."""
_WANDER_SPEED: Final = 0.5
"""Largest speed of a wandering robot, m/s ..."""
_WANDER_TURN_SPEED: Final = 0.8
"""... and its largest turning speed, rad/s."""
_FREE_HALF_WIDTH: Final = 0.35
"""Metres to each side of the middle that must be free ahead."""
_STOP_DISTANCE: Final = 0.5
"""The robot turns on the spot when something is nearer ahead than this, metres ..."""
_GO_DISTANCE: Final = 0.9
"""... and until nothing is nearer than this."""


class RouteProgress:
    """Way-points that are passed one after another, each within ``arrival`` metres of it."""

    def __init__(self, start: Pose2D, waypoints: Sequence[Point], arrival: float) -> None:
        self._arrival = arrival
        self._targets = [Pose2D(x, y) for x, y in waypoints]
        self._legs = [a.distance(b) for a, b in pairwise([start, *self._targets])]
        self._next = 0
        self.length = sum(self._legs)
        """Length of the whole route, metres."""
        self.left = self.length
        """Length from the last known place through all way-points that are left, metres; 0 at the end."""

    @property
    def goal(self) -> Pose2D | None:
        """The next way-point, map frame; None when all are passed, or there were none."""
        return self._targets[self._next] if self._next < len(self._targets) else None

    @property
    def arrived(self) -> bool:
        """True where there were way-points, and all are passed."""
        return bool(self._targets) and self.goal is None

    def advance(self, T_map_base: Pose2D) -> None:
        """Take note of where the robot is, and pass the way-points it has reached."""
        while (goal := self.goal) is not None:
            distance = T_map_base.distance(goal)
            self.left = distance + sum(self._legs[self._next + 1 :])
            if distance > self._arrival:
                return
            self._next += 1
        self.left = 0.0


class Pilot(Protocol):
    """Decides the next command."""

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D | None:
        """Command from this estimated pose and this scan; None when the route is done."""
        ...

    @property
    def progress(self) -> float:
        """Share of the route that is behind, 0 to 1."""
        ...


class WaypointPilot:
    """Drives a route's way-points one after another; without way-points it stands still and is never done."""

    def __init__(self, route: Route, start: Pose2D) -> None:
        self._route = route
        self._route_progress = RouteProgress(start, route.waypoints, route.arrival)

    def command(self, T_map_base: Pose2D, scan: LaserScan | None = None) -> Twist2D | None:
        """Command from this estimated pose; None when the last way-point is reached."""
        if not self._route.waypoints:
            return Twist2D()
        self._route_progress.advance(T_map_base)
        goal = self._route_progress.goal
        return None if goal is None else self._towards(T_map_base.bearing(goal))

    @property
    def progress(self) -> float:
        """Share of the route that is behind, 0 to 1."""
        length = self._route_progress.length
        return min(max(1.0 - self._route_progress.left / length, 0.0), 1.0) if length else 0.0

    def _towards(self, bearing: float) -> Twist2D:
        limit = self._route.turn_speed
        angular = min(max(_TURN_GAIN * bearing, -limit), limit)
        linear = self._route.speed * cos(bearing) if abs(bearing) < _TURN_FIRST else 0.0
        return Twist2D(linear, angular)


class Passenger:
    """Commands nothing, and is never done: for a robot that others drive."""

    @property
    def progress(self) -> float:
        """Nothing, as nobody knows how much there is."""
        return 0.0

    def command(self, T_map_base: Pose2D, scan: LaserScan | None = None) -> Twist2D | None:
        """No motion."""
        return Twist2D()


class ReplayPilot(Passenger):
    """A passenger of a recorded log, which drives as it once did, and whose end ends the run."""

    def __init__(self, scans: int) -> None:
        self._scans, self._seen = scans, 0

    @property
    def progress(self) -> float:
        """Share of the log's scans that were seen, 0 to 1."""
        return self._seen / self._scans

    def command(self, T_map_base: Pose2D, scan: LaserScan | None = None) -> Twist2D | None:
        """No motion; the scan counts as seen."""
        self._seen += 1
        return Twist2D()


class Wanderer:
    """Goes where there is room, turns where there is none, and is never done; the pose is not asked for."""

    progress = 0.0

    def __init__(self) -> None:
        self._turning = 0.0  # rad/s, while it turns on the spot

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D:
        """Command from what the scan shows."""
        ahead, side = _room(scan)
        if ahead < (_GO_DISTANCE if self._turning else _STOP_DISTANCE):
            self._turning = self._turning or float(np.copysign(_WANDER_TURN_SPEED, side))
            return Twist2D(0.0, self._turning)
        self._turning = 0.0
        angular = float(np.clip(side, -_WANDER_TURN_SPEED, _WANDER_TURN_SPEED))
        return Twist2D(min(_WANDER_SPEED, ahead - 0.4 * _STOP_DISTANCE), angular)


def _room(scan: LaserScan) -> tuple[float, float]:
    """Metres that are free ahead, and to which side there is more room: positive to the left, near 1 at most."""
    ranges = np.where(scan.echoes, scan.ranges, np.where(np.isposinf(scan.ranges), scan.range_max, np.inf))
    known, angles = np.isfinite(ranges), scan.bearings
    x, y = ranges[known] * np.cos(angles[known]), ranges[known] * np.sin(angles[known])
    ahead = x[(np.abs(y) < _FREE_HALF_WIDTH) & (x > 0.0)]
    front = np.abs(angles[known]) < 0.5 * np.pi
    side = float(y[front].sum() / max(np.abs(y[front]).sum(), 1e-9)) if front.any() else 0.0
    return float(ahead.min()) if len(ahead) else 0.0, side


class LocalizeThenDrive:
    """Wanders while the place is not known, and drives as another pilot says while it is."""

    def __init__(self, known: Callable[[], bool], then: Pilot) -> None:
        self._known, self._then, self._wanderer = known, then, Wanderer()

    @property
    def progress(self) -> float:
        """Progress of the other pilot."""
        return self._then.progress

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D | None:
        """Command from this estimated pose, if it is known, or from what the scan shows."""
        return (self._then if self._known() else self._wanderer).command(T_map_base, scan)
