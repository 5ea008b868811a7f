"""The world of a scenario as a plan: upright prisms on a floor, z = 0. Metres and radians, map frame."""

from __future__ import annotations

from slam.config import Section
from slam.pose import FloatArray
from slam.run.scenario.furniture import Box, Cylinder, Table
from slam.run.scenario.prism import Prism, disc, rectangle
from slam.run.scenario.ros_map import RosMap
from slam.run.scenario.wall import Door, Wall

__all__ = ["Box", "Cylinder", "Door", "Prism", "RosMap", "Table", "Wall", "World", "disc", "rectangle"]


class World(Section):
    """All that stands on the floor."""

    walls: tuple[Wall, ...] = ()
    """With their doors."""
    boxes: tuple[Box, ...] = ()
    """Cupboards, crates, steps."""
    tables: tuple[Table, ...] = ()
    """Of which a low lidar sees the legs."""
    cylinders: tuple[Cylinder, ...] = ()
    """Pillars, bins, plant pots."""
    map: RosMap | None = None
    """A ROS map whose occupied cells stand up as solids."""

    def prisms(self) -> list[Prism]:
        """Every solid of the world, kind by kind."""
        things: list[Wall | Box | Table | Cylinder] = [*self.walls, *self.boxes, *self.tables, *self.cylinders]
        return [*(prism for thing in things for prism in thing.prisms()), *(self.map.prisms() if self.map else ())]

    def outlines(self, height: float) -> list[FloatArray]:
        """Outlines (N, 2) of what a horizontal plane at this height cuts: what a lidar there can see."""
        return [prism.footprint for prism in self.prisms() if prism.bottom <= height <= prism.top]

    def joined(self, other: World) -> World:
        """Both in one; the map is this one's."""
        return World(
            walls=self.walls + other.walls,
            boxes=self.boxes + other.boxes,
            tables=self.tables + other.tables,
            cylinders=self.cylinders + other.cylinders,
            map=self.map,
        )
