"""The world of a scenario as a plan: upright prisms on a floor, z = 0. Metres and radians, map frame."""

from __future__ import annotations

from collections.abc import Sequence

from slam.config import Section
from slam.pose import FloatArray
from slam.scenario.furniture import Box, Cylinder, Movable, Table, movable
from slam.scenario.prism import Prism, disc, rectangle
from slam.scenario.ros_map import RosMap
from slam.scenario.wall import Door, Wall

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
        """Every solid of the world, kind by kind; what can be pushed, where it stands when a run begins."""
        return self._prisms([*self.walls, *self._furniture])

    def fixed_prisms(self) -> list[Prism]:
        """Every solid that nothing moves."""
        return self._prisms([*self.walls, *(piece for piece in self._furniture if piece.mass is None)])

    def movables(self) -> list[Movable]:
        """The furniture that the robot can push."""
        return [thing for piece in self._furniture if (thing := movable(piece)) is not None]

    def outlines(self, height: float) -> list[FloatArray]:
        """Outlines (N, 2) of what a horizontal plane at this height cuts: what a lidar there can see."""
        return [prism.footprint for prism in self.prisms() if prism.bottom <= height <= prism.top]

    @property
    def _furniture(self) -> list[Box | Table | Cylinder]:
        return [*self.boxes, *self.tables, *self.cylinders]

    def _prisms(self, things: Sequence[Wall | Box | Table | Cylinder]) -> list[Prism]:
        """Prisms of these things, then those of the map."""
        return [*(prism for thing in things for prism in thing.prisms()), *(self.map.prisms() if self.map else ())]

    def joined(self, other: World) -> World:
        """Both in one; the map is this one's."""
        return World(
            walls=self.walls + other.walls,
            boxes=self.boxes + other.boxes,
            tables=self.tables + other.tables,
            cylinders=self.cylinders + other.cylinders,
            map=self.map,
        )
