"""A plant without physics: a point that goes exactly where it is told, among upright walls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slam.errors import ScenarioError
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scenario.schema import Scenario

_HALF_TRACK = 0.165
_REACH = 5.6
"""Metres that a real URG-04LX says it can see."""


def scenario_plant(scenario: Scenario) -> KinematicPlant:
    """Make a plant among the walls that the scenario's lidar can see, at its start; without its noise and errors."""
    outlines = scenario.world.outlines(scenario.lidar.height)
    if not outlines:
        raise ScenarioError(f"{scenario.name}: nothing to see: the world is empty; choose a scenario with walls")
    reach = max(_REACH, scenario.lidar.description.lidar.range_max)
    return KinematicPlant(outlines, scenario.robot.start.pose, scenario.lidar.mount.pose, reach)


class KinematicPlant:
    """Walls are closed outlines (N, 2) in the map frame, metres; the robot drives through them, and has no sonar."""

    def __init__(
        self, outlines: Sequence[FloatArray], start: Pose2D, T_base_laser: Pose2D, reach: float = _REACH
    ) -> None:
        self._begins = np.concatenate(outlines)
        self._sides = np.concatenate([np.roll(outline, -1, axis=0) for outline in outlines]) - self._begins
        self._start = self.T_map_base = start
        self._T_base_laser = T_base_laser
        self._reach = reach
        self._left = self._right = 0.0
        self._setpoint = Twist2D()
        self.elapsed = 0.0
        self.stalled = False

    @property
    def odometry(self) -> Pose2D:
        """Exact pose of the base, in the frame where it was put down."""
        return self._start.between(self.T_map_base)

    @property
    def travel(self) -> tuple[float, float]:
        return self._left, self._right

    def advance(self, seconds: float, setpoint: Twist2D) -> None:
        self._setpoint = setpoint
        self.elapsed += seconds
        ahead, turn = setpoint.linear * seconds, setpoint.angular * seconds * _HALF_TRACK
        self._left += ahead - turn
        self._right += ahead + turn
        self.T_map_base = self.T_map_base @ setpoint.motion(seconds)

    def bumpers(self) -> tuple[bool, ...]:
        return ()

    def sonar(self) -> tuple[float, ...]:
        return ()

    def ranges(self, bearings: FloatArray, ahead: float = 0.0, increment: float = 0.0) -> FloatArray:
        """Return the distance along each ray to the nearest wall; the sensor goes straight from first beam to last."""
        begin, end = (self._T_map_laser(ahead + seconds) for seconds in (0.0, (len(bearings) - 1) * increment))
        share = np.linspace(0.0, 1.0, len(bearings))
        headings = bearings + begin.theta + share * begin.between(end).theta
        places = begin.translation + share[:, None] * (end.translation - begin.translation)
        rays, to_wall = unit_vectors(headings), self._begins - places[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            across = rays[:, :1] * self._sides[:, 1] - rays[:, 1:] * self._sides[:, 0]
            distance = (to_wall[..., 0] * self._sides[:, 1] - to_wall[..., 1] * self._sides[:, 0]) / across
            along = (to_wall[..., 0] * rays[:, 1:] - to_wall[..., 1] * rays[:, :1]) / across
        hit = (distance > 0.0) & (distance <= self._reach) & (along >= 0.0) & (along <= 1.0)
        nearest: FloatArray = np.where(hit, distance, np.inf).min(axis=1)
        return nearest

    def _T_map_laser(self, ahead: float) -> Pose2D:
        return self.T_map_base @ self._setpoint.motion(ahead) @ self._T_base_laser
