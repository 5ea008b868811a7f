"""What the generators of corridors have in common: walls with recesses, and furniture along them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Final, Self

import numpy as np
from pydantic import Field, model_validator

from slam.config import Section
from slam.scenario.generators.side import SLOT, Side
from slam.scenario.values import Count, Length
from slam.scenario.world_plan import World

_LEAST_DEPTH: Final = 0.2
"""Of furniture, metres."""
_BODY: Final = 0.2
"""Half of the width that somebody walking takes, metres."""
_BESIDE_ROBOT: Final = 0.6
"""From the robot's way to where people walk, metres, at least."""
_LANE_WITH_PEOPLE: Final = 2.0 * (_BESIDE_ROBOT + _BODY)


class Passage(Section):
    """A way between walls, whose middle stays free."""

    seed: int = Field(0, ge=0)
    """Of all that is random; left out, it is drawn with the scenario's seed."""
    width: Length = 2.5
    """Between the walls, metres."""
    lane: float = Field(1.2, ge=0.8)
    """Width that stays free in the middle, metres; at least 1.6 with people."""
    recesses: Count = 4
    """How many there are in the walls, as of doors; each 1 m long."""
    recess_depth: float = Field(0.25, ge=0, le=1000)
    """Metres."""
    boxes: Count = 8
    """How many stand along the walls."""
    tables: Count = 2
    """How many stand along the walls."""
    people: Count = 0
    """How many walk up and down beside the robot's way."""

    @property
    def depth(self) -> float:
        """How far furniture may reach from a wall, metres."""
        return (self.width - self.lane) / 2.0

    @abstractmethod
    def sides(self) -> Sequence[Side]:
        """The faces of its walls."""

    def furnished(self, rng: np.random.Generator) -> World:
        """The walls with their recesses, and the furniture: each in a slot of its own, drawn at random."""
        sides = self.sides()
        slots = [(side, slot) for side in sides for slot in range(side.slots)]
        drawn = [slots[k] for k in rng.permutation(len(slots))]
        recesses, rest = drawn[: self.recesses], drawn[self.recesses :]
        walls = [side.wall([slot for owner, slot in recesses if owner is side], self.recess_depth) for side in sides]
        boxes = [side.box(slot, self.depth, rng) for side, slot in rest[: self.boxes]]
        tables = [side.table(slot, self.depth) for side, slot in rest[self.boxes : self.boxes + self.tables]]
        return World(walls=tuple(walls), boxes=tuple(boxes), tables=tuple(tables))

    def walking_offset(self, rng: np.random.Generator) -> float:
        """Where somebody walks: metres to the left of the middle, beside the robot's way and within the lane."""
        return float(rng.choice([-1.0, 1.0]) * rng.uniform(_BESIDE_ROBOT, self.lane / 2.0 - _BODY))

    @model_validator(mode="after")
    def _things_fit(self) -> Self:
        if self.depth < _LEAST_DEPTH - 1e-9 and self.boxes + self.tables:
            raise ValueError(
                f"width = {self.width:g} m and lane = {self.lane:g} m leave less than {_LEAST_DEPTH} m on either side "
                f"for furniture; widen it, or set boxes and tables to 0"
            )
        if self.lane > self.width:
            raise ValueError(f"lane = {self.lane:g} m is wider than the passage, width = {self.width:g} m")
        if self.people and self.lane < _LANE_WITH_PEOPLE:
            raise ValueError(
                f"lane = {self.lane:g} m is too narrow to meet people in; at least {_LANE_WITH_PEOPLE:g} m"
            )
        wanted, there = self.recesses + self.boxes + self.tables, sum(side.slots for side in self.sides())
        if wanted > there:
            raise ValueError(f"{wanted} recesses, boxes and tables; the walls have room for {there}, {SLOT} m for each")
        return self
