"""Furniture: boxes, tables and cylinders."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from slam.config import Section
from slam.pose import Pose2D
from slam.scenario.solids import Prism, disc, rectangle
from slam.scenario.values import Angle, Length, Point, SmallLength

Mass = Annotated[float, Field(ge=0.1, le=1000)]
"""Mass, kilograms."""


@dataclass(frozen=True, slots=True, eq=False)
class Movable:
    """A thing that can be pushed: ``prisms`` in its own frame, which has the pose ``T_map_thing`` at the start."""

    T_map_thing: Pose2D
    prisms: tuple[Prism, ...]
    mass: float
    """Mass, kilograms."""


class Box(Section):
    """A box on the floor."""

    center: Point
    """Centre of its outline, map frame, metres."""
    size: tuple[Length, Length, Length]
    """Length along ``yaw``, width, height; metres."""
    yaw: Angle = 0.0
    """Counter-clockwise from the x axis, radians."""
    mass: Mass | None = None
    """Mass of a box that the robot can push, kilograms; without it the box is fixed."""

    def prisms(self) -> Iterator[Prism]:
        """Yield the box itself."""
        yield Prism(rectangle(self.center, self.size[0], self.size[1], self.yaw), 0.0, self.size[2])


class Table(Section):
    """A table: four square legs and a top; a low lidar sees the legs only."""

    center: Point
    """Centre of its outline, map frame, metres."""
    size: tuple[Length, Length, Length] = (1.2, 0.6, 0.75)
    """Length along ``yaw``, width, height; metres."""
    yaw: Angle = 0.0
    """Counter-clockwise from the x axis, radians."""
    leg: SmallLength = 0.05
    """Side of a leg, metres."""
    top: SmallLength = 0.03
    """Thickness of the top, metres."""
    mass: Mass | None = None
    """Mass of a table that the robot can push, kilograms; without it the table is fixed."""

    def prisms(self) -> Iterator[Prism]:
        """Yield the legs, then the top."""
        length, width, height = self.size
        place = Pose2D(*self.center, self.yaw)
        for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            foot = place @ Pose2D(sx * (length - self.leg) / 2, sy * (width - self.leg) / 2)
            yield Prism(rectangle((foot.x, foot.y), self.leg, self.leg, self.yaw), 0.0, height - self.top)
        yield Prism(rectangle(self.center, length, width, self.yaw), height - self.top, height)


class Cylinder(Section):
    """A cylinder on the floor: a pillar, a bin, a plant pot."""

    center: Point
    """Centre of its outline, map frame, metres."""
    radius: Length
    """Radius, metres."""
    height: Length = 1.0
    """Height, metres."""
    mass: Mass | None = None
    """Mass of a cylinder that the robot can push, kilograms; without it the cylinder is fixed."""

    def prisms(self) -> Iterator[Prism]:
        """Yield one prism with enough sides to be round within 1 mm."""
        yield Prism(disc(self.center, self.radius), 0.0, self.height)


Furniture = Box | Table | Cylinder


def movable(piece: Furniture) -> Movable | None:
    """Make a movable thing of a piece of furniture; None if it is fixed."""
    if piece.mass is None:
        return None
    at_origin = piece.model_copy(update={"center": (0.0, 0.0), "yaw": 0.0})
    yaw = 0.0 if isinstance(piece, Cylinder) else piece.yaw
    return Movable(Pose2D(*piece.center, yaw), tuple(at_origin.prisms()), piece.mass)
