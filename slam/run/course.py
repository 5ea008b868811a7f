"""A route as metres that are behind and metres that are left."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from slam.pose import Pose2D
from slam.scenario.values import Point


class Course:
    """Way-points that are passed one after another, each within ``arrival`` metres of it."""

    def __init__(self, start: Pose2D, waypoints: Sequence[Point], arrival: float) -> None:
        self._arrival = arrival
        self._targets = [Pose2D(x, y) for x, y in waypoints]
        self._legs = [a.distance(b) for a, b in pairwise([start, *self._targets])]
        self._next = 0
        self.length = sum(self._legs)
        """Of all of it, metres."""
        self.left = self.length
        """From the last place it was told, through all way-points that are left, metres; 0 at the end."""

    @property
    def goal(self) -> Pose2D | None:
        """The next way-point, map frame; None when all are passed, or there were none."""
        return self._targets[self._next] if self._next < len(self._targets) else None

    @property
    def arrived(self) -> bool:
        """Whether there were way-points, and all are passed."""
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
