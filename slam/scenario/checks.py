"""Checks of a drawn scenario: solids at positions of the robot, and valid but implausible values."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from slam.pose import FloatArray
from slam.scenario.robot_config import Limits
from slam.scenario.schema import Route, Scenario
from slam.scenario.solids import ROBOT_RADIUS, clearance, obstacle_footprints, sample_path
from slam.scenario.values import Point
from slam.scenario.world_plan import Person, World
from slam.scenario.yaml_file import KeyPath

HALF_WIDTH: Final = 0.19
"""Half of the robot's width, metres: it cannot pass a solid nearer to its path than this."""
LARGE: Final = 50.0
"""Length or height of furniture above which it is probably a mistake, metres."""
VAST: Final = 1000.0
"""Length of a world above which it is probably a mistake, metres."""
FAR: Final = 20.0
"""Distance from all solids above which a position is probably a mistake, metres."""
RUNNING: Final = 3.0
"""Speed of a person above which it is probably a mistake, m/s."""

Finding = tuple[KeyPath, str]
"""The path of a key, and the fault of its value."""


class _Solids:
    """Footprints with their bounding boxes, with which each piece of a path is compared first."""

    def __init__(self, footprints: Sequence[FloatArray]) -> None:
        self._footprints = footprints
        self._low = np.array([outline.min(axis=0) for outline in footprints]).reshape(-1, 2)
        self._high = np.array([outline.max(axis=0) for outline in footprints]).reshape(-1, 2)

    def tight_spot(self, leg: tuple[Point, Point], least: float) -> tuple[float, float] | None:
        """Find the first point of a straight path that is nearer than ``least`` metres to a solid."""
        points = sample_path(leg, step=least / 2.0)
        for begin in range(0, len(points), 20):
            part = points[begin : begin + 20]
            low, high = part.min(axis=0) - least, part.max(axis=0) + least
            near = np.flatnonzero(((self._high >= low) & (self._low <= high)).all(axis=1)).tolist()
            tight = part[clearance(part, [self._footprints[k] for k in near]) < least]
            if len(tight):
                return float(tight[0, 0]), float(tight[0, 1])
        return None


def find_obstruction(scenario: Scenario) -> Finding | None:
    """Find the first position of the robot that a solid occupies."""
    free = clearance(np.array(scenario.path), obstacle_footprints(scenario.world.prisms()))
    for (key, (x, y)), distance in zip(_robot_places(scenario), free, strict=True):
        if distance < ROBOT_RADIUS:
            where = "inside a solid" if distance == 0.0 else f"{distance:.2f} m from a solid"
            return key, f"({x:g}, {y:g}) is {where}; the robot needs {ROBOT_RADIUS} m around its middle"
    return None


def find_warnings(scenario: Scenario) -> Iterator[Finding]:
    """Find the keys with questionable values, in the order of the file's sections."""
    world, bounds = scenario.world, scenario.world.bounds()
    solids, fixed = (_Solids(obstacle_footprints(prisms)) for prisms in (world.prisms(), world.fixed_prisms()))
    if bounds is not None:
        yield from _vast_world(*bounds)
    yield from _large_things(world)
    yield from _running_people(scenario.people)
    yield from _blocked_people(scenario.people, solids)
    if bounds is not None:
        yield from _far_places(scenario, *bounds)
    yield from _blocked_route(scenario.path, fixed)
    yield from _unreachable_speeds(scenario.route, scenario.robot.limits)


def _robot_places(scenario: Scenario) -> Iterator[tuple[KeyPath, Point]]:
    """List the points of the robot's path, each with its key."""
    keys = [("route", "waypoints", k) for k in range(len(scenario.route.waypoints))]
    yield from zip([("robot", "start"), *keys], scenario.path, strict=True)


def _vast_world(low: FloatArray, high: FloatArray) -> Iterator[Finding]:
    length, width = high - low
    if max(length, width) > VAST:
        yield ("world",), f"{length:.0f} m by {width:.0f} m; lengths are in metres"


def _large_things(world: World) -> Iterator[Finding]:
    sizes = [
        *((("world", "boxes", k, "size"), max(box.size)) for k, box in enumerate(world.boxes)),
        *((("world", "tables", k, "size"), max(table.size)) for k, table in enumerate(world.tables)),
        *((("world", "cylinders", k, "radius"), 2.0 * cylinder.radius) for k, cylinder in enumerate(world.cylinders)),
        *((("world", "cylinders", k, "height"), cylinder.height) for k, cylinder in enumerate(world.cylinders)),
    ]
    for key, length in sizes:
        if length > LARGE:
            yield key, f"this thing measures {length:g} m; sizes are in metres"


def _running_people(people: Sequence[Person]) -> Iterator[Finding]:
    for k, person in enumerate(people):
        if person.speed > RUNNING:
            yield ("people", k, "speed"), f"{person.speed:g} m/s is running; people walk at 1 to 2 m/s"


def _blocked_people(people: Sequence[Person], solids: _Solids) -> Iterator[Finding]:
    for k, person in enumerate(people):
        ends = (*person.waypoints, person.waypoints[0]) if person.closed else person.waypoints
        for leg in pairwise(ends):
            if (spot := solids.tight_spot(leg, person.leg_radius)) is not None:
                yield ("people", k, "waypoints"), f"the path {_leg(leg)} leads through a solid at {_place(spot)}"
                break


def _far_places(scenario: Scenario, low: FloatArray, high: FloatArray) -> Iterator[Finding]:
    for key, point in _robot_places(scenario):
        beyond = float(np.maximum(low - point, point - high).max())
        if beyond > FAR:
            yield key, f"{_place(point)} is {beyond:.0f} m away from all solids; positions are in metres"


def _blocked_route(path: Sequence[Point], solids: _Solids) -> Iterator[Finding]:
    for k, leg in enumerate(pairwise(path)):
        if (spot := solids.tight_spot(leg, HALF_WIDTH)) is not None:
            passes = f"the path {_leg(leg)} leads through or too near to a solid at {_place(spot)}"
            yield ("route", "waypoints", k), f"{passes}; the robot drives straight, and is {2 * HALF_WIDTH:g} m wide"


def _unreachable_speeds(route: Route, limits: Limits) -> Iterator[Finding]:
    if route.speed > limits.linear:
        yield ("route", "speed"), f"the robot drives no faster than robot.limits.linear = {limits.linear:g} m/s"
    if route.turn_speed > limits.angular:
        yield ("route", "turn_speed"), f"the robot turns no faster than robot.limits.angular = {limits.angular:g} rad/s"


def _leg(leg: tuple[Point, Point]) -> str:
    return f"from {_place(leg[0])} to {_place(leg[1])}"


def _place(point: Point) -> str:
    return f"({point[0]:.4g}, {point[1]:.4g})"
