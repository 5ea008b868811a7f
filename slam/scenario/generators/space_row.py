"""A row of spaces along a corridor: rooms behind doors, and bays that are open to it."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import Final, NamedTuple

import numpy as np

from slam.pose import Pose2D
from slam.scenario.furniture import Box, Cylinder, Table
from slam.scenario.generators.passage import WallFace
from slam.scenario.values import Point, millimetres, readable_point
from slam.scenario.wall import Door, Wall
from slam.scenario.world_plan import World

THICKNESS: Final[float] = Wall.model_fields["thickness"].default
_PILLAR_FROM: Final = 3.5
"""Length from which a bay has a pillar in its opening, metres."""
_BAY_FURNITURE: Final = 0.6
"""Largest distance of furniture in a bay from its back wall, metres."""
_TABLES: Final = 0.3
"""Share of tables in the furniture; the rest is boxes."""


class Space(NamedTuple):
    """A room behind a wall with a door or, without one, a bay that is open to the corridor; in the frame of its row."""

    low: float
    """x at which it begins, metres."""
    high: float
    """x at which it ends, metres."""
    depth: float
    """Distance from the corridor's wall to its own back wall, metres."""
    door: Door | None


@dataclass(frozen=True, slots=True)
class SpaceRow:
    """The spaces on one side of a corridor. ``T_map_row``: x along the corridor's middle, y towards these spaces."""

    T_map_row: Pose2D
    front: float
    """y of the middle of the corridor's wall, metres."""
    spaces: tuple[Space, ...]

    def point(self, x: float, y: float) -> Point:
        """Transform a point of the row's frame to the map."""
        place = self.T_map_row @ Pose2D(x, y)
        return readable_point(place.x, place.y)

    def walls(self) -> Iterator[Wall]:
        """Yield the wall to the corridor and the back wall of each space, then the partitions."""
        depths: dict[float, float] = {}
        for space in self.spaces:
            if space.door is not None:
                yield self._along(space, self.front, (space.door,))
            yield self._along(space, self.front + space.depth)
            for x in (space.low, space.high):
                depths[x] = max(space.depth, depths.get(x, 0.0))
        for x, depth in depths.items():
            yield Wall(points=(self.point(x, self.front), self.point(x, self.front + depth)))

    def furniture(self, share: float, reach: float, rng: np.random.Generator) -> World:
        """Place a box or a table beside this share of the spaces, in bays at the back, and pillars into wide bays.

        Furniture in the corridor is at most ``reach`` metres from its wall.
        """
        boxes: list[Box] = []
        tables: list[Table] = []
        for space in self.spaces:
            face = self._free_face(space)
            depth = reach if space.door else min(_BAY_FURNITURE, space.depth)
            if rng.random() >= share or not face.slots:
                continue
            slot = int(rng.integers(face.slots))
            if rng.random() < _TABLES:
                tables.append(face.table(slot, depth))
            else:
                boxes.append(face.box(slot, depth, rng))
        return World(boxes=tuple(boxes), tables=tuple(tables), cylinders=tuple(self._pillars(rng)))

    def _pillars(self, rng: np.random.Generator) -> Iterator[Cylinder]:
        """Yield a pillar in the opening of each wide bay."""
        for space in self.spaces:
            if space.door is None and space.high - space.low > _PILLAR_FROM:
                (radius,) = millimetres(rng.uniform(0.1, 0.2))
                middle = (space.low + space.high) / 2.0
                yield Cylinder(center=self.point(middle, self.front), radius=radius, height=1.0)

    def _along(self, space: Space, y: float, doors: tuple[Door, ...] = ()) -> Wall:
        return Wall(points=(self.point(space.low, y), self.point(space.high, y)), doors=doors)

    def _free_face(self, space: Space) -> WallFace:
        """Return the face of a bay's back wall, or of the longer part of the corridor's wall beside a door."""
        low, high, y = space.low, space.high, self.front + space.depth
        if space.door is not None:
            y, door_begin, door_end = self.front, low + space.door.at, low + space.door.end
            low, high = (low, door_begin) if door_begin - low > high - door_end else (door_end, high)
        return WallFace(self.T_map_row @ Pose2D(high, y - THICKNESS / 2.0, pi), high - low)


def drawn_lengths(total: float, span: tuple[float, float], rng: np.random.Generator) -> tuple[float, ...]:
    """Draw lengths from the span, and stretch them all to fill ``total``; their mean is at least that of the span."""
    weights = rng.uniform(*span, max(int(total / np.mean(span)), 1))
    return tuple((total * weights / weights.sum()).tolist())
