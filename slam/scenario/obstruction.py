"""Solids that stand where the robot is to start or to pass."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from slam.scenario.clearance import ROBOT_RADIUS, clearance, in_the_way
from slam.scenario.schema import Scenario
from slam.scenario.yaml_file import Location


def obstruction(scenario: Scenario) -> tuple[Location, str] | None:
    """The first place where the robot is to stand and a solid stands already: its key, and what is wrong; or None."""
    places = list(_places(scenario))
    points = np.array([point for _, point in places])
    free = clearance(points, in_the_way(scenario.world.prisms()))
    for (key, (x, y)), distance in zip(places, free, strict=True):
        if distance < ROBOT_RADIUS:
            where = "inside a solid" if distance == 0.0 else f"{distance:.2f} m from a solid"
            return key, f"({x:g}, {y:g}) is {where}; the robot needs {ROBOT_RADIUS} m around its middle"
    return None


def _places(scenario: Scenario) -> Iterator[tuple[Location, tuple[float, float]]]:
    start = scenario.robot.start
    yield ("robot", "start"), (start.x, start.y)
    for index, waypoint in enumerate(scenario.route.waypoints):
        yield ("route", "waypoints", index), waypoint
