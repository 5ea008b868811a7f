"""A room of a generated office, with its furniture and people."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, pi
from typing import Final, Self

import numpy as np

from slam.pose import FloatArray, Pose2D
from slam.scenario.furniture import Box, Cylinder, Furniture, Table
from slam.scenario.solids import clearance, disc, rectangle, sample_path
from slam.scenario.values import Point, millimetres, readable_point
from slam.scenario.world_plan import Person, World

_TRIES: Final = 20
"""Number of attempts to place a thing before it is left out."""
_FROM_ROUTE: Final = 0.45
"""Least distance of furniture from the robot's path, metres."""
_WALKER_FROM_ROUTE: Final = 0.7
"""Least distance of people from the robot's path, to the middle of the body, metres."""
_WALKER_FROM_THINGS: Final = 0.35
"""Least distance of people from furniture, metres."""


@dataclass(frozen=True, slots=True)
class Room:
    """A rectangle between the faces of its walls, ``low`` to ``high`` corner, metres, map frame.

    Its contents stay clear of ``route`` and ``leaves``: points (N, 2) in and near the room, on the robot's path and on
    the outlines of doors.
    """

    low: Point
    high: Point
    route: FloatArray
    leaves: FloatArray

    @classmethod
    def between(cls, low: Point, high: Point, route: FloatArray, leaves: FloatArray) -> Self:
        """Make the room, with the relevant points of all paths and doors."""
        return cls(low, high, *(_near(points, low, high) for points in (route, leaves)))

    def furnish(self, count: int, rng: np.random.Generator) -> list[Furniture]:
        """Place up to ``count`` pieces of furniture, apart from each other."""
        placed: list[Furniture] = []
        for _ in range(count):
            tries = (self._piece(rng) for _ in range(_TRIES))
            free = (piece for piece in tries if self._has_place(piece, placed))
            placed += [piece for piece in [next(free, None)] if piece]
        return placed

    def person(self, furniture: Sequence[Furniture], rng: np.random.Generator) -> Person | None:
        """Place a person who walks to and fro, clear of the furniture too; None if there is no room."""
        things = [_footprint(piece) for piece in furniture]
        for _ in range(_TRIES):
            ends = [self._point(0.4, 0.4, rng) for _ in range(2)]
            path = sample_path(ends)
            if (
                _all_far(path, self.route, _WALKER_FROM_ROUTE)
                and _all_far(path, self.leaves, _WALKER_FROM_THINGS)
                and clearance(path, things).min() >= _WALKER_FROM_THINGS
            ):
                (speed,) = millimetres(rng.uniform(0.4, 1.0))
                return Person(waypoints=(ends[0], ends[1]), speed=speed, pause=2.0)
        return None

    def _has_place(self, piece: Furniture, others: Sequence[Furniture]) -> bool:
        outline = _footprint(piece)
        return (
            all(_apart(piece, other) for other in others)
            and bool((clearance(self.route, [outline]) >= _FROM_ROUTE).all())
            and bool((clearance(self.leaves, [outline]) > 0.0).all())
        )

    def _piece(self, rng: np.random.Generator) -> Furniture:
        """Draw a piece of one of three kinds, somewhere in the room and wholly inside."""
        kind = rng.integers(3)
        if kind == 0:
            (radius,) = millimetres(rng.uniform(0.1, 0.3))
            return Cylinder(center=self._point(radius, radius, rng), radius=radius, height=0.8)
        length, width = millimetres(rng.uniform(0.5, 1.4), rng.uniform(0.4, 0.7))
        turned = bool(rng.integers(2))
        dx, dy = (width / 2.0, length / 2.0) if turned else (length / 2.0, width / 2.0)
        center = self._point(dx, dy, rng)
        yaw = pi / 2.0 if turned else 0.0
        if kind == 1:
            return Table(center=center, size=(length, width, 0.74), yaw=yaw)
        return Box(center=center, size=(length, width, 1.0), yaw=yaw)

    def _point(self, dx: float, dy: float, rng: np.random.Generator) -> Point:
        """Draw a point at least ``dx`` and ``dy`` inside the walls."""
        x, y = rng.uniform(self.low[0] + dx, self.high[0] - dx), rng.uniform(self.low[1] + dy, self.high[1] - dy)
        return readable_point(x, y)


def _near(points: FloatArray, low: Point, high: Point) -> FloatArray:
    """Return the points (N, 2) that matter to a room between these corners."""
    lowest, highest = np.subtract(low, _WALKER_FROM_ROUTE), np.add(high, _WALKER_FROM_ROUTE)
    return points[np.all((points > lowest) & (points < highest), axis=1)]


def _all_far(path: FloatArray, points: FloatArray, distance: float) -> bool:
    return bool((np.linalg.norm(path[:, np.newaxis] - points, axis=2) >= distance).all())


def furniture_world(furniture: Sequence[Furniture]) -> World:
    """Make a world of the pieces of furniture alone."""
    return World(
        boxes=tuple(piece for piece in furniture if isinstance(piece, Box)),
        tables=tuple(piece for piece in furniture if isinstance(piece, Table)),
        cylinders=tuple(piece for piece in furniture if isinstance(piece, Cylinder)),
    )


def _footprint(piece: Furniture) -> FloatArray:
    """Return the outline of a piece; of a table, that of its top."""
    if isinstance(piece, Cylinder):
        return disc(piece.center, piece.radius)
    return rectangle(piece.center, piece.size[0], piece.size[1], piece.yaw)


def _apart(one: Furniture, other: Furniture) -> bool:
    """Return True if the circles around two pieces do not meet."""
    return Pose2D(*one.center).distance(Pose2D(*other.center)) > _radius(one) + _radius(other)


def _radius(piece: Furniture) -> float:
    return piece.radius if isinstance(piece, Cylinder) else hypot(*piece.size[:2]) / 2.0
