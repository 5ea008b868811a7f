"""Cautions about values of a scenario that are allowed and hardly meant, such as a way through a wall."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from slam.pose import FloatArray
from slam.scenario.clearance import clearance, in_the_way, sampled
from slam.scenario.people import Person
from slam.scenario.schema import Scenario
from slam.scenario.values import Point
from slam.scenario.yaml_file import Location

HALF_WIDTH: Final = 0.19
"""Half of the robot's width, metres: where a solid is nearer to its way than this, it cannot pass."""
LARGE: Final = 50.0
"""Length or height of furniture beyond which it is hardly meant, metres."""
VAST: Final = 1000.0
"""Length of a world beyond which it is hardly meant, metres."""
FAR: Final = 20.0
"""Distance from everything that stands beyond which a place is hardly meant, metres."""
RUNNING: Final = 3.0
"""Speed beyond which a person is hardly meant to walk, m/s."""

Caution = tuple[Location, str]
"""The path of a key, and what is strange about its value."""


class _Solids:
    """Footprints with the boxes around them, by which each piece of a way is compared with its neighbours only."""

    def __init__(self, footprints: Sequence[FloatArray]) -> None:
        self._footprints = footprints
        self._low = np.array([outline.min(axis=0) for outline in footprints]).reshape(-1, 2)
        self._high = np.array([outline.max(axis=0) for outline in footprints]).reshape(-1, 2)

    def tight_spot(self, leg: tuple[Point, Point], least: float) -> tuple[float, float] | None:
        """The first point of a straight way that is nearer than ``least`` metres to a solid."""
        points = sampled(leg, step=least / 2.0)
        for begin in range(0, len(points), 20):
            part = points[begin : begin + 20]
            low, high = part.min(axis=0) - least, part.max(axis=0) + least
            near = np.flatnonzero(((self._high >= low) & (self._low <= high)).all(axis=1)).tolist()
            tight = part[clearance(part, [self._footprints[k] for k in near]) < least]
            if len(tight):
                return float(tight[0, 0]), float(tight[0, 1])
        return None


def cautions(scenario: Scenario) -> Iterator[Caution]:
    """One caution for each key whose value is strange, in the order of the file's sections."""
    yield from _vast_world(scenario)
    yield from _large_things(scenario)
    yield from _hasty_people(scenario)
    yield from _blocked_people(scenario)
    yield from _far_places(scenario)
    yield from _blocked_route(scenario)
    yield from _unreachable_speeds(scenario)


def _vast_world(scenario: Scenario) -> Iterator[Caution]:
    if (extent := _extent(scenario)) is not None:
        length, width = extent[1] - extent[0]
        if max(length, width) > VAST:
            yield ("world",), f"{length:.0f} m by {width:.0f} m; lengths are in metres"


def _extent(scenario: Scenario) -> tuple[FloatArray, FloatArray] | None:
    """The least and the largest x and y of all that stands; None where nothing does."""
    outlines = [prism.footprint for prism in scenario.world.prisms()]
    if not outlines:
        return None
    corners = np.concatenate(outlines)
    return corners.min(axis=0), corners.max(axis=0)


def _large_things(scenario: Scenario) -> Iterator[Caution]:
    world = scenario.world
    sizes = [
        *((("world", "boxes", k, "size"), max(box.size)) for k, box in enumerate(world.boxes)),
        *((("world", "tables", k, "size"), max(table.size)) for k, table in enumerate(world.tables)),
        *((("world", "cylinders", k, "radius"), 2.0 * cylinder.radius) for k, cylinder in enumerate(world.cylinders)),
        *((("world", "cylinders", k, "height"), cylinder.height) for k, cylinder in enumerate(world.cylinders)),
    ]
    for key, length in sizes:
        if length > LARGE:
            yield key, f"this thing measures {length:g} m; sizes are in metres"


def _hasty_people(scenario: Scenario) -> Iterator[Caution]:
    for k, person in enumerate(scenario.people):
        if person.speed > RUNNING:
            yield ("people", k, "speed"), f"{person.speed:g} m/s is running; people walk at 1 to 2 m/s"


def _blocked_people(scenario: Scenario) -> Iterator[Caution]:
    solids = _Solids(in_the_way(scenario.world.prisms()))
    for k, person in enumerate(scenario.people):
        for leg in pairwise(_round(person)):
            if (spot := solids.tight_spot(leg, person.leg_radius)) is not None:
                yield ("people", k, "waypoints"), f"the way {_leg(leg)} leads through a solid at {_place(spot)}"
                break


def _round(person: Person) -> tuple[Point, ...]:
    return (*person.waypoints, person.waypoints[0]) if person.closed else person.waypoints


def _far_places(scenario: Scenario) -> Iterator[Caution]:
    if (extent := _extent(scenario)) is None:
        return
    low, high = extent
    start = scenario.robot.start
    stops = enumerate(scenario.route.waypoints)
    for key, point in [(("robot", "start"), (start.x, start.y)), *((("route", "waypoints", k), p) for k, p in stops)]:
        beyond = float(np.maximum(low - point, point - high).max())
        if beyond > FAR:
            yield key, f"{_place(point)} is {beyond:.0f} m outside of everything that stands; places are in metres"


def _blocked_route(scenario: Scenario) -> Iterator[Caution]:
    solids = _Solids(in_the_way(scenario.world.fixed_prisms()))
    start = scenario.robot.start
    for k, leg in enumerate(pairwise([(start.x, start.y), *scenario.route.waypoints])):
        if (spot := solids.tight_spot(leg, HALF_WIDTH)) is not None:
            passes = f"the way {_leg(leg)} leads through or too near to a solid at {_place(spot)}"
            yield ("route", "waypoints", k), f"{passes}; the robot drives straight, and is {2 * HALF_WIDTH:g} m wide"


def _unreachable_speeds(scenario: Scenario) -> Iterator[Caution]:
    route, limits = scenario.route, scenario.robot.limits
    if route.speed > limits.linear:
        yield ("route", "speed"), f"the robot drives no faster than robot.limits.linear = {limits.linear:g} m/s"
    if route.turn_speed > limits.angular:
        yield ("route", "turn_speed"), f"the robot turns no faster than robot.limits.angular = {limits.angular:g} rad/s"


def _leg(leg: tuple[Point, Point]) -> str:
    return f"from {_place(leg[0])} to {_place(leg[1])}"


def _place(point: Point) -> str:
    return f"({point[0]:.4g}, {point[1]:.4g})"
