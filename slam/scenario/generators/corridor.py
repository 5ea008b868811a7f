"""A straight corridor, driven to its end and back."""

from math import pi
from typing import Final, Literal

import numpy as np
from pydantic import Field

from slam.pose import Pose2D
from slam.scenario.generators.passage import PassageGenerator, WallFace
from slam.scenario.values import Place, millimetres
from slam.scenario.wall import Wall
from slam.scenario.world_plan import GeneratedWorld, Person

_TURN: Final = 1.0
"""Distance from the end at which the robot turns, metres."""


class CorridorGenerator(PassageGenerator):
    """Two walls along the x axis, from x = 0 to ``length``, and one at each end."""

    kind: Literal["corridor"] = "corridor"
    """The name of this generator."""
    length: float = Field(20.0, ge=4.0, le=1000)
    """Length, metres."""

    def wall_faces(self) -> tuple[WallFace, WallFace]:
        """List the right face and the left one, seen from the start."""
        y = self.width / 2.0
        return WallFace(Pose2D(0.0, -y, 0.0), self.length), WallFace(Pose2D(self.length, y, pi), self.length)

    def build(self) -> GeneratedWorld:
        """Build the world of these parameters: the same in any process."""
        rng = np.random.default_rng(self.seed)
        world = self.furnished(rng)
        y = self.width / 2.0
        ends = tuple(Wall(points=((x, -y), (x, y))) for x in (-0.05, self.length + 0.05))
        people = tuple(self._person(rng) for _ in range(self.people))
        far = round(self.length - _TURN, 3)
        return GeneratedWorld(
            world.model_copy(update={"walls": world.walls + ends}), Place(x=_TURN), ((far, 0.0), (_TURN, 0.0)), people
        )

    def _person(self, rng: np.random.Generator) -> Person:
        """Make a person who walks up and down a part of the corridor."""
        length = rng.uniform(0.25, 0.75) * (self.length - 2.0 * _TURN)
        near = rng.uniform(_TURN, self.length - _TURN - length)
        near, far, y = millimetres(near, near + length, self.walking_offset(rng))
        speed, start = millimetres(rng.uniform(0.5, 1.3), rng.uniform(0.0, length))
        return Person(waypoints=((near, y), (far, y)), speed=speed, start=start, pause=1.0)
