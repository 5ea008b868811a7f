"""A scenario in a few words."""

from __future__ import annotations

from itertools import pairwise
from math import dist

import numpy as np

from slam.scenario.schema import Scenario


def overview(scenario: Scenario) -> str:
    """Name and description, then a line each on the world, the people and the route."""
    return "\n".join(
        [
            f"{scenario.name}: {scenario.description}" if scenario.description else scenario.name,
            f"world: {_world(scenario)}",
            f"people: {len(scenario.people)}",
            f"route: {route_length(scenario):.1f} m over {len(scenario.route.waypoints)} way-points; "
            f"seed {scenario.seed}",
        ]
    )


def route_length(scenario: Scenario) -> float:
    """From the start over all way-points, metres."""
    start = scenario.robot.start
    return sum(dist(a, b) for a, b in pairwise([(start.x, start.y), *scenario.route.waypoints]))


def _world(scenario: Scenario) -> str:
    prisms = scenario.world.prisms()
    if not prisms:
        return "empty"
    corners = np.concatenate([prism.footprint for prism in prisms])
    width, depth = np.ptp(corners, axis=0)
    height = scenario.lidar.height
    seen = len(scenario.world.outlines(height))
    return (
        f"{width:.1f} m by {depth:.1f} m, {len(prisms)} solids, {seen} of them cut by the lidar's plane at {height:g} m"
    )
