"""Passages between walls with recesses, and furniture along them: the base of the corridor and the loop."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from pydantic import Field, model_validator

from slam.config import Section
from slam.pose import Pose2D
from slam.scenario.furniture import Box, Table
from slam.scenario.values import Count, Length, Point, millimetres, readable_point
from slam.scenario.wall import Wall
from slam.scenario.world_plan import World

SLOT: Final = 1.3
"""Length of wall that each thing has for itself, metres."""
_RECESS: Final = (0.15, 1.15)
"""Start and end of a recess in its slot, metres."""
_THICKNESS: Final[float] = Wall.model_fields["thickness"].default
_MIN_DEPTH: Final = 0.2
"""Least depth of furniture, metres."""
_BODY: Final = 0.2
"""Half of the width of a walking person, metres."""
_BESIDE_ROBOT: Final = 0.6
"""Least distance from the robot's path to walking people, metres."""
_LANE_WITH_PEOPLE: Final = 2.0 * (_BESIDE_ROBOT + _BODY)


@dataclass(frozen=True, slots=True)
class WallFace:
    """Face of a wall, with slots for recesses and furniture. ``T_map_face``: x along it, y into the open."""

    T_map_face: Pose2D
    length: float
    outer_corner: bool = False
    """True if the passage bends around both ends of this face, so that its wall must not extend beyond them."""

    @property
    def slots(self) -> int:
        """Number of slots along the face."""
        return int(self.length / SLOT)

    def wall(self, recessed: Sequence[int], depth: float) -> Wall:
        """Make the wall behind the face, with recesses in these slots."""
        inset, middle = (_THICKNESS / 2.0 if self.outer_corner else 0.0), -_THICKNESS / 2.0
        line = [(inset, middle)]
        for slot in sorted(recessed):
            low, high = (self._begin(slot) + edge for edge in _RECESS)
            line += [(low, middle), (low, middle - depth), (high, middle - depth), (high, middle)]
        line.append((self.length - inset, middle))
        return Wall(points=tuple(self._point(x, y) for x, y in line))

    def box(self, slot: int, depth: float, rng: np.random.Generator) -> Box:
        """Make a box near the wall that reaches no farther than ``depth`` metres into the open."""
        length, width = rng.uniform(0.3, 1.0), rng.uniform(0.5, 1.0) * min(depth, 0.7)
        height, turn = rng.uniform(0.45, 1.2), rng.uniform(-0.3, 0.3)
        reach = length * abs(np.sin(turn)) + width * np.cos(turn)
        if reach > depth:
            turn, reach = 0.0, width
        center = self._point(self._begin(slot) + SLOT / 2.0, reach / 2.0)
        length, width, height, yaw = millimetres(length, width, height, self.T_map_face.theta + turn)
        return Box(center=center, size=(length, width, height), yaw=yaw)

    def table(self, slot: int, depth: float) -> Table:
        """Make a table along the wall."""
        width = min(depth, 0.7)
        center = self._point(self._begin(slot) + SLOT / 2.0, width / 2.0)
        return Table(center=center, size=(1.2, round(width, 3), 0.74), yaw=round(self.T_map_face.theta, 6))

    def _begin(self, slot: int) -> float:
        """Start of a slot, metres along the face."""
        return (self.length - self.slots * SLOT) / 2.0 + slot * SLOT

    def _point(self, x: float, y: float) -> Point:
        point = self.T_map_face @ Pose2D(x, y)
        return readable_point(point.x, point.y)


class PassageGenerator(Section):
    """A path between walls, whose middle stays free."""

    seed: int = Field(0, ge=0)
    """Seed of the world; by default it is drawn with the scenario's seed."""
    width: Length = 2.5
    """Width between the walls, metres."""
    lane: float = Field(1.2, ge=0.8)
    """Width that stays free in the middle, metres; at least 1.6 with people."""
    recesses: Count = 4
    """Number of recesses in the walls, like those of doors; each is 1 m long."""
    recess_depth: float = Field(0.25, ge=0, le=1000)
    """Depth of a recess, metres."""
    boxes: Count = 8
    """Number of boxes along the walls."""
    tables: Count = 2
    """Number of tables along the walls."""
    people: Count = 0
    """Number of people who walk up and down beside the robot's path."""

    @property
    def depth(self) -> float:
        """Distance that furniture may reach from a wall, metres."""
        return (self.width - self.lane) / 2.0

    @abstractmethod
    def wall_faces(self) -> Sequence[WallFace]:
        """List the faces of its walls."""

    def furnished(self, rng: np.random.Generator) -> World:
        """Build the walls with their recesses, and the furniture: each in a slot of its own, drawn at random."""
        faces = self.wall_faces()
        slots = [(face, slot) for face in faces for slot in range(face.slots)]
        drawn = [slots[k] for k in rng.permutation(len(slots))]
        recesses, rest = drawn[: self.recesses], drawn[self.recesses :]
        walls = [face.wall([slot for owner, slot in recesses if owner is face], self.recess_depth) for face in faces]
        boxes = [face.box(slot, self.depth, rng) for face, slot in rest[: self.boxes]]
        tables = [face.table(slot, self.depth) for face, slot in rest[self.boxes : self.boxes + self.tables]]
        return World(walls=tuple(walls), boxes=tuple(boxes), tables=tuple(tables))

    def walking_offset(self, rng: np.random.Generator) -> float:
        """Draw where a person walks: metres to the left of the middle, beside the robot's path and within the lane."""
        return float(rng.choice([-1.0, 1.0]) * rng.uniform(_BESIDE_ROBOT, self.lane / 2.0 - _BODY))

    @model_validator(mode="after")
    def _things_fit(self) -> Self:
        if self.depth < _MIN_DEPTH - 1e-9 and self.boxes + self.tables:
            raise ValueError(
                f"width = {self.width:g} m and lane = {self.lane:g} m leave less than {_MIN_DEPTH} m on either side "
                f"for furniture; widen it, or set boxes and tables to 0"
            )
        if self.lane > self.width:
            raise ValueError(f"lane = {self.lane:g} m is wider than the passage, width = {self.width:g} m")
        if self.people and self.lane < _LANE_WITH_PEOPLE:
            raise ValueError(
                f"lane = {self.lane:g} m is too narrow to meet people in; at least {_LANE_WITH_PEOPLE:g} m"
            )
        wanted, slots = self.recesses + self.boxes + self.tables, sum(face.slots for face in self.wall_faces())
        if wanted > slots:
            raise ValueError(f"{wanted} recesses, boxes and tables; the walls have room for {slots}, {SLOT} m for each")
        return self
