"""A campus: four wings of rooms, joined to a ring by passages, with another passage across its court."""

from collections.abc import Iterator
from functools import reduce
from itertools import pairwise
from math import atan2, pi
from typing import Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from slam.config import Section
from slam.pose import FloatArray, Pose2D
from slam.scenario.generators.ring_side import RingSide, walls_around_corner
from slam.scenario.generators.space_row import THICKNESS, Space, SpaceRow, drawn_lengths
from slam.scenario.values import Length, Place, Point, Span, millimetres
from slam.scenario.wall import Door, Wall
from slam.scenario.world_plan import GeneratedWorld, World

_LANE: Final = 2.4
"""Width that stays free in the middle of a corridor, metres."""
_BESIDE_DOOR: Final = 0.3
"""Least wall between a door and the corner of its room, metres."""
_DOOR: Final = 0.95
"""Width of a door, metres."""
_FOR_DOOR: Final = _DOOR + 2.0 * _BESIDE_DOOR
"""Length of a room that a door fits into, metres."""
_MIN_WIDTH: Final = _LANE + 0.4
"""Least width of a corridor, with furniture 0.2 m deep at its walls, metres."""
_CROSSED: Final = (0, 2)
"""Numbers of the wings that the passage across the court joins."""
_ACROSS: Final = (0.45, 0.6)
"""Position of that passage as a share of the first wing's side."""


class CampusGenerator(Section):
    """Four wings around a court. The robot drives once around, again over the beginning, and across the court.

    A lidar with a short range sees only walls in most of a passage; every wing has rooms of other sizes.
    """

    kind: Literal["campus"] = "campus"
    """The name of this generator."""
    seed: int = Field(0, ge=0)
    """Seed of the world; by default it is drawn with the scenario's seed."""
    size: tuple[Length, Length] = (48.0, 32.0)
    """Size of the ring's centre line, along x and y, metres."""
    skew: float = Field(1.5, ge=0, le=5)
    """Largest shift of the two corners opposite the start in x and in y, metres: most wings are not parallel."""
    passage_width: float = Field(2.8, ge=1.4, le=1000)
    """Width of the passages between the walls, metres."""
    passage_length: Span = (7.5, 9.0)
    """Least and largest distance from a corner of the ring to a wing, metres."""
    corridor_width: Span = (3.2, 3.8)
    """Least and largest width of a wing's corridor, metres."""
    room_length: Span = (2.5, 6.0)
    """Least and largest length of a room along the corridor, metres. Rooms are stretched to fill their row."""
    room_depth: Span = (1.5, 4.5)
    """Least and largest depth of a room, metres."""
    shut: float = Field(0.6, ge=0, le=1)
    """Share of closed doors, on average."""
    bays: float = Field(0.25, ge=0, le=1)
    """Share of the rooms without a wall to the corridor, on average."""
    furniture: float = Field(0.5, ge=0, le=1)
    """Share of the rooms with a box or a table, on average: in the corridor beside the door, or in the bay."""

    def build(self) -> GeneratedWorld:
        """Build the world of these parameters: the same in any process."""
        rng = np.random.default_rng(self.seed)
        corners = self._corners(rng)
        sides = [self._side(a, b, rng) for a, b in pairwise([*corners, corners[0]])]
        share = rng.uniform(*_ACROSS)
        crossings = {k: sides[k].length * (share if k == 0 else 1.0 - share) for k in _CROSSED}
        rows = [row for k, side in enumerate(sides) for row in self._rows(side, crossings.get(k), rng)]
        walls = [
            *(wall for before, after in _neighbours(sides) for wall in walls_around_corner(before, after, self._half)),
            *self._walls_across(sides, crossings),
            *(wall for row in rows for wall in row.walls()),
        ]
        furniture = [row.furniture(self.furniture, row.front - (THICKNESS + _LANE) / 2.0, rng) for row in rows]
        world = reduce(World.joined, furniture, World(walls=tuple(walls)))
        start = sides[0].begin + 1.0
        return GeneratedWorld(world, Place(x=round(start, 3)), self._route(sides, crossings, start))

    def _corners(self, rng: np.random.Generator) -> list[FloatArray]:
        """Draw the corners of the ring, counter-clockwise; the first is the origin, the second on the x axis."""
        (x, y), shifts = self.size, rng.uniform(-self.skew, self.skew, (2, 2))
        return [np.zeros(2), np.array([x, 0.0]), np.array([x, y]) + shifts[0], np.array([0.0, y]) + shifts[1]]

    def _side(self, first: FloatArray, second: FloatArray, rng: np.random.Generator) -> RingSide:
        vector = second - first
        length = float(np.hypot(*vector))
        begin, rest = rng.uniform(*self.passage_length, 2)
        front = (rng.uniform(*self.corridor_width) + THICKNESS) / 2.0
        T_map_side = Pose2D(float(first[0]), float(first[1]), atan2(vector[1], vector[0]))
        return RingSide(T_map_side, length, float(begin), float(length - rest), float(front))

    def _rows(self, side: RingSide, crossing: float | None, rng: np.random.Generator) -> tuple[SpaceRow, SpaceRow]:
        """Draw the spaces towards the court, with a gap for the passage across it, and those outside."""
        gap = () if crossing is None else (crossing - self._half, crossing + self._half)
        ends = side.begin, *gap, side.end
        inside = (self._spaces(low, high, rng) for low, high in zip(ends[::2], ends[1::2], strict=True))
        outside = self._spaces(side.length - side.end, side.length - side.begin, rng)
        turned = side.T_map_side @ Pose2D(side.length, 0.0, pi)
        return SpaceRow(side.T_map_side, side.front, sum(inside, ())), SpaceRow(turned, side.front, outside)

    def _spaces(self, low: float, high: float, rng: np.random.Generator) -> tuple[Space, ...]:
        """Draw the spaces between two positions of a row."""
        bounds = millimetres(*np.cumsum([low, *drawn_lengths(high - low, self.room_length, rng)]))
        return tuple(self._space(a, b, rng) for a, b in pairwise(bounds))

    def _space(self, low: float, high: float, rng: np.random.Generator) -> Space:
        """Draw a room with its door, or a bay without a door."""
        (depth,) = millimetres(rng.uniform(*self.room_depth))
        return Space(low, high, depth, None if rng.random() < self.bays else self._door(high - low, rng))

    def _door(self, length: float, rng: np.random.Generator) -> Door:
        """Draw a door in a wall of this length."""
        at, angle = millimetres(rng.uniform(_BESIDE_DOOR, length - _BESIDE_DOOR - _DOOR), rng.uniform(pi / 2.0, 2.0))
        hinge: Literal["begin", "end"] = "begin" if rng.integers(2) else "end"
        return Door(at=at, width=_DOOR, angle=0.0 if rng.random() < self.shut else angle, hinge=hinge)

    @property
    def _half(self) -> float:
        """Distance from the middle of a passage to the middle of its walls, metres."""
        return (self.passage_width + THICKNESS) / 2.0

    def _walls_across(self, sides: list[RingSide], crossings: dict[int, float]) -> list[Wall]:
        """List both walls of the passage across the court."""
        first, second = (sides[k] for k in _CROSSED)
        x, other = (crossings[k] for k in _CROSSED)
        return [
            Wall(points=(first.point(x + out, first.front), second.point(other - out, second.front)))
            for out in (-self._half, self._half)
        ]

    def _route(self, sides: list[RingSide], crossings: dict[int, float], start: float) -> tuple[Point, ...]:
        """Return the route: around, over the beginning again, across the court, and half around again."""
        first, *corners = (side.point(0.0, 0.0) for side in sides)
        home = sides[0].point(start, 0.0)
        over, back = (sides[k].point(crossings[k], 0.0) for k in _CROSSED)
        return (*corners, first, home, over, back, corners[-1], first, home)

    @model_validator(mode="after")
    def _doors_fit(self) -> Self:
        shortest = float(np.mean(self.room_length)) * self.room_length[0] / self.room_length[1]
        if shortest < _FOR_DOOR:
            raise ValueError(f"room_length: rooms of {shortest:.2f} m might be drawn; at least {_FOR_DOOR:g} m")
        if self.corridor_width[0] < max(self.passage_width, _MIN_WIDTH):
            least = max(self.passage_width, _MIN_WIDTH)
            raise ValueError(f"corridor_width: {self.corridor_width[0]:g} m is too narrow; at least {least:g} m")
        return self

    @model_validator(mode="after")
    def _wings_fit(self) -> Self:
        reach = self.corridor_width[1] / 2.0 + self.room_depth[1] + 1.0
        if self.passage_length[0] < reach:
            raise ValueError(f"passage_length: {self.passage_length[0]:g} m lets the wings meet; at least {reach:g} m")
        x = (self.passage_length[1] + self._half + _FOR_DOOR) / (1.0 - _ACROSS[1]) + 2.0 * self.skew
        y = 2.0 * (self.passage_length[1] + self.skew) + _FOR_DOOR
        if self.size[0] < x or self.size[1] < y:
            raise ValueError(f"size = {list(self.size)} m leaves no room for wings; at least {x:.1f} m by {y:.1f} m")
        return self


def _neighbours(sides: list[RingSide]) -> Iterator[tuple[RingSide, RingSide]]:
    """Pair each side of the ring with the previous one."""
    return zip([sides[-1], *sides[:-1]], sides, strict=True)
