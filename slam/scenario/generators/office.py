"""An office: rooms on both sides of a corridor, some of them on the route."""

from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from math import cos, pi
from typing import Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from slam.config import Section
from slam.pose import Pose2D
from slam.scenario.generators.room import Room, furniture_world
from slam.scenario.solids import sample_path
from slam.scenario.values import Count, Place, Point, Span, millimetres, readable_point
from slam.scenario.wall import Door, Wall
from slam.scenario.world_plan import GeneratedWorld, World

_THICKNESS: Final[float] = Wall.model_fields["thickness"].default
_INTO_ROOM: Final = 1.1
"""Distance that the robot drives into a room on its route, metres."""
_BESIDE_DOOR: Final = 0.2
"""Minimum length of wall between a door (or its open leaf) and the corner of the room, metres."""


@dataclass(frozen=True, slots=True)
class RoomRow:
    """The rooms on one side. ``T_map_row``: x along the corridor's middle, y towards these rooms."""

    T_map_row: Pose2D
    bounds: tuple[float, ...]
    """x of the partitions, and of both ends."""
    doors: tuple[Door, ...]

    def point(self, x: float, y: float) -> Point:
        """Transform a point of the row's frame to the map."""
        place = self.T_map_row @ Pose2D(x, y)
        return readable_point(place.x, place.y)


class OfficeGenerator(Section):
    """A corridor along the x axis with the same number of rooms on its left and on its right."""

    kind: Literal["office"] = "office"
    """The name of this generator."""
    seed: int = Field(0, ge=0)
    """Seed of the world; by default it is drawn with the scenario's seed."""
    rooms: int = Field(3, ge=1, le=50)
    """Rooms on each side."""
    room_length: Span = (3.0, 5.0)
    """Least and largest length of a room along the corridor, metres."""
    room_depth: float = Field(4.0, ge=2.0, le=1000)
    """Depth of the rooms, metres."""
    corridor_width: float = Field(2.0, ge=1.2, le=1000)
    """Width between the walls, metres."""
    door_width: float = Field(0.95, ge=0.8, le=1000)
    """Width of the doors, metres."""
    door_angle: Span = (1.6, 2.0)
    """Least and largest angle of an open door's leaf, radians; less than pi / 2 would block the path."""
    shut: float = Field(0.25, ge=0, le=1)
    """Share of closed doors, on average."""
    visits: Count = 2
    """Largest number of open rooms on the route."""
    furniture: Count = 3
    """Boxes, tables and cylinders in each room, as far as there is space beside the robot's path."""
    people: Count = 0
    """People who walk in rooms, as far as there is space beside the robot's path."""

    def build(self) -> GeneratedWorld:
        """Build the world of these parameters: the same in any process."""
        rng = np.random.default_rng(self.seed)
        rows = self._rows(rng)
        waypoints = self._waypoints(rows, rng)
        route = sample_path([(1.0, 0.0), *waypoints], step=0.1)
        walls = self._walls(rows)
        outlines = [sample_path(leaf.footprint, step=0.1) for wall in walls for leaf in wall.leaves()]
        leaves = np.concatenate(outlines)
        rooms = [Room.between(low, high, route, leaves) for row in rows for low, high in self._floors(row)]
        furniture = [room.furnish(self.furniture, rng) for room in rooms]
        chosen = rng.permutation(np.resize(rng.permutation(len(rooms)), self.people))
        people = [rooms[k].person(furniture[k], rng) for k in chosen]
        world = reduce(World.joined, map(furniture_world, furniture), World(walls=walls))
        return GeneratedWorld(world, Place(x=1.0), waypoints, tuple(person for person in people if person))

    def _rows(self, rng: np.random.Generator) -> tuple[RoomRow, RoomRow]:
        """Draw the left and the right row: the same room lengths in another order, so that both end together."""
        lengths = rng.uniform(*self.room_length, self.rooms)
        total = float(lengths.sum())
        frames = Pose2D(), Pose2D(total, 0.0, pi)
        bounds = [millimetres(*np.cumsum([0.0, *rng.permutation(lengths)])) for _ in frames]
        left, right = (RoomRow(T, xs, self._doors(xs, rng)) for T, xs in zip(frames, bounds, strict=True))
        return left, right

    def _doors(self, bounds: tuple[float, ...], rng: np.random.Generator) -> tuple[Door, ...]:
        """Draw a door for each room."""
        doors = []
        for low, high in pairwise(bounds):
            at = rng.uniform(low + self._beside_door, high - self._beside_door - self.door_width)
            at, angle = millimetres(at, 0.0 if rng.random() < self.shut else rng.uniform(*self.door_angle))
            hinge: Literal["begin", "end"] = "begin" if rng.integers(2) else "end"
            doors.append(Door(at=at, width=self.door_width, angle=angle, hinge=hinge))
        return tuple(doors)

    def _waypoints(self, rows: tuple[RoomRow, RoomRow], rng: np.random.Generator) -> tuple[Point, ...]:
        """Draw a route along the corridor into some open rooms, to its far end, and back."""
        doors = [(row, door.at + door.width / 2.0) for row in rows for door in row.doors if door.angle]
        visited = [doors[k] for k in rng.permutation(len(doors))[: self.visits]]
        inside = self._room_front + _INTO_ROOM
        detours = sorted((row.point(x, 0.0), row.point(x, inside)) for row, x in visited)
        stops = [point for front, room in detours for point in (front, room, front)]
        far = rows[0].bounds[-1] - 1.0
        return (*stops, (round(far, 3), 0.0), (1.0, 0.0))

    @property
    def _beside_door(self) -> float:
        """Least distance from a door to the corner of its room, metres."""
        return _BESIDE_DOOR - self.door_width * cos(self.door_angle[1])

    @property
    def _room_front(self) -> float:
        """Coordinate y of the room-side face of the corridor wall, in the frame of a row, metres."""
        return self.corridor_width / 2.0 + _THICKNESS

    def _floors(self, row: RoomRow) -> list[tuple[Point, Point]]:
        """List the lower and the upper corner of each room, map frame."""
        half, front = _THICKNESS / 2.0, self._room_front
        corners = [
            (row.point(x0 + half, front), row.point(x1 - half, front + self.room_depth))
            for x0, x1 in pairwise(row.bounds)
        ]
        return [((min(a[0], b[0]), min(a[1], b[1])), (max(a[0], b[0]), max(a[1], b[1]))) for a, b in corners]

    def _walls(self, rows: tuple[RoomRow, RoomRow]) -> tuple[Wall, ...]:
        """List the front wall (with doors), back wall and partitions of each row, then both ends of the corridor."""
        front, back = self._room_front - _THICKNESS / 2.0, self._room_front + self.room_depth + _THICKNESS / 2.0
        walls = []
        for row in rows:
            end = row.bounds[-1]
            walls.append(Wall(points=(row.point(0.0, front), row.point(end, front)), doors=row.doors))
            walls.append(Wall(points=(row.point(0.0, back), row.point(end, back))))
            walls += [Wall(points=(row.point(x, front), row.point(x, back))) for x in row.bounds]
        ends = [Wall(points=(rows[0].point(x, -front), rows[0].point(x, front))) for x in rows[0].bounds[:: self.rooms]]
        return (*walls, *ends)

    @model_validator(mode="after")
    def _doors_fit(self) -> Self:
        least = max(self.door_width + 2.0 * self._beside_door, 2.0)
        if self.room_length[0] < least:
            raise ValueError(f"room_length: {self.room_length[0]:g} m is too short; at least {least:.2f} m")
        if self.door_angle[0] < pi / 2.0 or self.door_angle[1] > pi:
            raise ValueError(f"door_angle = {list(self.door_angle)} rad must lie within pi / 2 and pi")
        return self
