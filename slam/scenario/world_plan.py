"""The world of a scenario as a plan: solids, and people who walk. Metres and radians, map frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from slam.config import Section
from slam.pose import FloatArray
from slam.scenario.furniture import Box, Cylinder, Furniture, Movable, Table, movable
from slam.scenario.ros_map import RosMap
from slam.scenario.solids import Prism, outlines_at
from slam.scenario.values import NotNegative, Place, Point, Positive, SmallLength, Within
from slam.scenario.wall import Wall


class World(Section):
    """All solids on the floor."""

    walls: tuple[Wall, ...] = ()
    """Walls with their doors."""
    boxes: tuple[Box, ...] = ()
    """Boxes: cupboards, crates, steps."""
    tables: tuple[Table, ...] = ()
    """Tables, of which a low lidar sees the legs."""
    cylinders: tuple[Cylinder, ...] = ()
    """Cylinders: pillars, bins, plant pots."""
    map: RosMap | None = None
    """A ROS map whose occupied cells become solids."""

    def prisms(self) -> list[Prism]:
        """List every solid of the world, kind by kind; movable ones at their start poses."""
        return self._prisms([*self.walls, *self._furniture])

    def fixed_prisms(self) -> list[Prism]:
        """List every fixed solid."""
        return self._prisms([*self.walls, *(piece for piece in self._furniture if piece.mass is None)])

    def movables(self) -> list[Movable]:
        """List the furniture that the robot can push."""
        return [thing for piece in self._furniture if (thing := movable(piece)) is not None]

    def outlines(self, height: float) -> list[FloatArray]:
        """List the outlines (N, 2) of the solids at this height: those that a lidar there can see."""
        return outlines_at(self.prisms(), height)

    def bounds(self) -> tuple[FloatArray, FloatArray] | None:
        """Find the least and the largest x and y of all solids; None without any."""
        outlines = [prism.footprint for prism in self.prisms()]
        if not outlines:
            return None
        corners = np.concatenate(outlines)
        return corners.min(axis=0), corners.max(axis=0)

    @property
    def _furniture(self) -> list[Furniture]:
        return [*self.boxes, *self.tables, *self.cylinders]

    def _prisms(self, things: Sequence[Wall | Furniture]) -> list[Prism]:
        """List the prisms of these things, then those of the map."""
        return [*(prism for thing in things for prism in thing.prisms()), *(self.map.prisms() if self.map else ())]

    def joined(self, other: World) -> World:
        """Join both worlds; the map is this one's."""
        return World(
            walls=self.walls + other.walls,
            boxes=self.boxes + other.boxes,
            tables=self.tables + other.tables,
            cylinders=self.cylinders + other.cylinders,
            map=self.map,
        )


class Person(Section):
    """A person who walks from way-point to way-point, for ever, and stops while the robot is in the way."""

    waypoints: tuple[Point, ...] = Field(min_length=1)
    """Way-points, metres, map frame; a single one: a person who stands there."""
    closed: bool = False
    """True: the path continues from the last way-point to the first; false: it returns the same way."""
    speed: Annotated[Positive, Within(0.0, 5.0, "m/s", "mm/s", 1e-3)] = 1.0
    """Speed, m/s."""
    pause: NotNegative = 0.0
    """Rest at each way-point, seconds."""
    start: NotNegative = 0.0
    """Distance along the path at which this person starts, metres."""
    leg_radius: SmallLength = 0.06
    """Radius of a leg, metres."""
    stance: SmallLength = 0.2
    """Distance between the middles of the legs, across the path, metres."""
    stride: SmallLength = 0.7
    """Distance between footprints of different legs, along the path, metres."""
    keep: Annotated[NotNegative, Within(0.0, 20.0, "m", "mm", 1e-3)] = 0.8
    """Distance to the middle of the robot ahead below which this person stops, metres. The feet are up to half a stride
    ahead of the middle of the person."""


@dataclass(frozen=True, slots=True)
class GeneratedWorld:
    """A world and its route: nothing is nearer than 0.3 m to the path from ``start`` on."""

    world: World
    start: Place
    waypoints: tuple[Point, ...]
    people: tuple[Person, ...] = ()
