"""What stands about: boxes, tables and cylinders."""

from __future__ import annotations

from collections.abc import Iterator

from slam.config import Section
from slam.pose import Pose2D
from slam.run.scenario.prism import Prism, disc, rectangle
from slam.run.scenario.values import Length, Point


class Box(Section):
    """A box on the floor."""

    center: Point
    """Of its outline, map frame, metres."""
    size: tuple[Length, Length, Length]
    """Length along ``yaw``, width, height; metres."""
    yaw: float = 0.0
    """Counter-clockwise from the x axis, radians."""

    def prisms(self) -> Iterator[Prism]:
        """The one."""
        yield Prism(rectangle(self.center, self.size[0], self.size[1], self.yaw), 0.0, self.size[2])


class Table(Section):
    """A table: four square legs and a top; a low lidar sees the legs only."""

    center: Point
    """Of its outline, map frame, metres."""
    size: tuple[Length, Length, Length] = (1.2, 0.6, 0.75)
    """Length along ``yaw``, width, height; metres."""
    yaw: float = 0.0
    """Counter-clockwise from the x axis, radians."""
    leg: Length = 0.05
    """Side of a leg, metres."""
    top: Length = 0.03
    """Thickness of the top, metres."""

    def prisms(self) -> Iterator[Prism]:
        """The legs, then the top."""
        length, width, height = self.size
        place = Pose2D(*self.center, self.yaw)
        for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            foot = place @ Pose2D(sx * (length - self.leg) / 2, sy * (width - self.leg) / 2)
            yield Prism(rectangle((foot.x, foot.y), self.leg, self.leg, self.yaw), 0.0, height - self.top)
        yield Prism(rectangle(self.center, length, width, self.yaw), height - self.top, height)


class Cylinder(Section):
    """A pillar, a bin, a plant pot: a round thing on the floor."""

    center: Point
    """Of its outline, map frame, metres."""
    radius: Length
    """Metres."""
    height: Length = 1.0
    """Metres."""

    def prisms(self) -> Iterator[Prism]:
        """One with so many sides that it is round within 1 mm."""
        yield Prism(disc(self.center, self.radius), 0.0, self.height)
