"""The world of a scenario as a plan: upright prisms on a floor, z = 0. Metres and radians, map frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from pydantic import Field

from slam.config import Section
from slam.pose import FloatArray, Pose2D
from slam.run.scenario.values import Point, Positive


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """A solid with the outline ``footprint`` (N, 2), counter-clockwise and convex, from ``bottom`` up to ``top``."""

    footprint: FloatArray
    bottom: float
    top: float


def rectangle(center: Point, length: float, width: float, yaw: float) -> FloatArray:
    """Corners (4, 2), counter-clockwise; ``length`` lies along ``yaw``."""
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * [length, width]
    return Pose2D(*center, yaw).transform(corners)


class Wall(Section):
    """A polyline that a wall of this thickness follows, along its middle."""

    points: tuple[Point, ...] = Field(min_length=2)
    closed: bool = False
    thickness: Positive = 0.1
    height: Positive = 1.0

    def prisms(self) -> Iterator[Prism]:
        """One for each stretch, half a thickness longer at both ends so that corners are filled."""
        ends = [*self.points, self.points[0]] if self.closed else self.points
        for (x0, y0), (x1, y1) in pairwise(ends):
            length, yaw = float(np.hypot(x1 - x0, y1 - y0)), float(np.arctan2(y1 - y0, x1 - x0))
            outline = rectangle(((x0 + x1) / 2, (y0 + y1) / 2), length + self.thickness, self.thickness, yaw)
            yield Prism(outline, 0.0, self.height)


class Box(Section):
    """A box on the floor."""

    center: Point
    size: tuple[Positive, Positive, Positive]
    """Positive along ``yaw``, width, height."""
    yaw: float = 0.0

    def prisms(self) -> Iterator[Prism]:
        """The one."""
        yield Prism(rectangle(self.center, self.size[0], self.size[1], self.yaw), 0.0, self.size[2])


class Table(Section):
    """A table: four square legs and a top; a low lidar sees the legs only."""

    center: Point
    size: tuple[Positive, Positive, Positive] = (1.2, 0.6, 0.75)
    """Positive along ``yaw``, width, height."""
    yaw: float = 0.0
    leg: Positive = 0.05
    """Side of a leg."""
    top: Positive = 0.03
    """Thickness of the top."""

    def prisms(self) -> Iterator[Prism]:
        """The legs, then the top."""
        length, width, height = self.size
        place = Pose2D(*self.center, self.yaw)
        for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            foot = place @ Pose2D(sx * (length - self.leg) / 2, sy * (width - self.leg) / 2)
            yield Prism(rectangle((foot.x, foot.y), self.leg, self.leg, self.yaw), 0.0, height - self.top)
        yield Prism(rectangle(self.center, length, width, self.yaw), height - self.top, height)


class World(Section):
    """All that stands on the floor."""

    walls: tuple[Wall, ...] = ()
    boxes: tuple[Box, ...] = ()
    tables: tuple[Table, ...] = ()

    def prisms(self) -> list[Prism]:
        """Every solid of the world, in the order of the file."""
        things: tuple[Wall | Box | Table, ...] = (*self.walls, *self.boxes, *self.tables)
        return [prism for thing in things for prism in thing.prisms()]

    def outlines(self, height: float) -> list[FloatArray]:
        """Outlines (N, 2) of what a horizontal plane at this height cuts: what a lidar there can see."""
        return [prism.footprint for prism in self.prisms() if prism.bottom <= height <= prism.top]
