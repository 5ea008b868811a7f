"""A corridor that leads around a block, driven once around."""

from math import pi
from typing import Literal, Self

import numpy as np
from pydantic import model_validator

from slam.pose import Pose2D
from slam.scenario.generators.passage import PassageGenerator, WallFace
from slam.scenario.values import Length, Place, Point, millimetres, readable_point
from slam.scenario.world_plan import GeneratedWorld, Person


class LoopGenerator(PassageGenerator):
    """A ring around a rectangular block; the robot starts in the middle of the side at y = 0."""

    kind: Literal["loop"] = "loop"
    """The name of this generator."""
    size: tuple[Length, Length] = (14.0, 8.0)
    """Size of the ring's centre line, along x and y, metres."""

    def wall_faces(self) -> tuple[WallFace, ...]:
        """List four faces of the outer walls, then four of the block."""
        outer, inner = self._ring(self.width / 2.0), self._ring(-self.width / 2.0)
        return (
            *(_face(outer[k], outer[(k + 1) % 4], outer_corner=False) for k in range(4)),
            *(_face(inner[(k + 1) % 4], inner[k], outer_corner=True) for k in range(4)),
        )

    def build(self) -> GeneratedWorld:
        """Build the world of these parameters: the same in any process."""
        rng = np.random.default_rng(self.seed)
        world = self.furnished(rng)
        first, *corners = self._ring(0.0)
        people = tuple(self._person(rng) for _ in range(self.people))
        return GeneratedWorld(world, Place(), (*corners, first, (0.0, 0.0)), people)

    def _ring(self, out: float) -> tuple[Point, Point, Point, Point]:
        """List the corners of the centre line, or of a rectangle ``out`` metres outside it; counter-clockwise."""
        x, y = self.size[0] / 2.0 + out, self.size[1] + out
        return (-x, -out), (x, -out), (x, y), (-x, y)

    def _person(self, rng: np.random.Generator) -> Person:
        """Make a person who walks around the block on one side of the robot's path, in either direction."""
        ring = self._ring(self.walking_offset(rng))[:: rng.choice([-1, 1])]
        speed, start = millimetres(rng.uniform(0.5, 1.3), rng.uniform(0.0, 2.0 * sum(self.size)))
        return Person(waypoints=tuple(readable_point(x, y) for x, y in ring), closed=True, speed=speed, start=start)

    @model_validator(mode="after")
    def _leaves_a_block(self) -> Self:
        least = self.width + 2.0 * self.recess_depth + 0.5
        if min(self.size) < least:
            raise ValueError(f"size = {list(self.size)} m leaves no block inside; at least {least:g} m each way")
        return self


def _face(start: Point, end: Point, outer_corner: bool) -> WallFace:
    run = np.subtract(end, start)
    yaw = float(np.arctan2(run[1], run[0]))
    return WallFace(Pose2D(*start, pi if yaw == -pi else yaw), float(np.linalg.norm(run)), outer_corner)
