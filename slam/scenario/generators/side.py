"""One side of a passage: the face of a wall, with places along it for recesses and furniture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from slam.pose import Pose2D
from slam.scenario.furniture import Box, Table
from slam.scenario.generators.site import millimetres
from slam.scenario.values import Point
from slam.scenario.wall import Wall

SLOT: Final = 1.3
"""Each thing has so much of a side for itself, metres."""
_RECESS: Final = (0.15, 1.15)
"""Where in its slot a recess begins and ends, metres."""
_THICKNESS: Final[float] = Wall.model_fields["thickness"].default


@dataclass(frozen=True, slots=True)
class Side:
    """``T_map_side``: x along the face, y off the wall into the open."""

    T_map_side: Pose2D
    length: float
    outer_corner: bool = False
    """The passage bends around both ends of this side, so that its wall must not stick out."""

    @property
    def slots(self) -> int:
        """How many things have a place along it."""
        return int(self.length / SLOT)

    def wall(self, recessed: Sequence[int], depth: float) -> Wall:
        """The wall behind the face, with recesses in these slots."""
        inset, middle = (_THICKNESS / 2.0 if self.outer_corner else 0.0), -_THICKNESS / 2.0
        line = [(inset, middle)]
        for slot in sorted(recessed):
            low, high = (self._begin(slot) + edge for edge in _RECESS)
            line += [(low, middle), (low, middle - depth), (high, middle - depth), (high, middle)]
        line.append((self.length - inset, middle))
        return Wall(points=tuple(self._point(x, y) for x, y in line))

    def box(self, slot: int, depth: float, rng: np.random.Generator) -> Box:
        """A box near the wall that reaches no farther than ``depth`` metres into the open."""
        length, width = rng.uniform(0.3, 1.0), rng.uniform(0.5, 1.0) * min(depth, 0.7)
        height, turn = rng.uniform(0.45, 1.2), rng.uniform(-0.3, 0.3)
        reach = length * abs(np.sin(turn)) + width * np.cos(turn)
        if reach > depth:
            turn, reach = 0.0, width
        center = self._point(self._begin(slot) + SLOT / 2.0, reach / 2.0)
        length, width, height, yaw = millimetres(length, width, height, self.T_map_side.theta + turn)
        return Box(center=center, size=(length, width, height), yaw=yaw)

    def table(self, slot: int, depth: float) -> Table:
        """A table along the wall."""
        width = min(depth, 0.7)
        center = self._point(self._begin(slot) + SLOT / 2.0, width / 2.0)
        return Table(center=center, size=(1.2, round(width, 3), 0.74), yaw=round(self.T_map_side.theta, 6))

    def _begin(self, slot: int) -> float:
        """Where a slot begins, metres along the side."""
        return (self.length - self.slots * SLOT) / 2.0 + slot * SLOT

    def _point(self, x: float, y: float) -> Point:
        point = self.T_map_side @ Pose2D(x, y)
        x, y = millimetres(point.x, point.y)
        return x, y
