"""Walls, and the doors in them."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate, pairwise
from math import hypot, pi
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from slam.config import Section
from slam.pose import Pose2D
from slam.scenario.solids import Prism, rectangle
from slam.scenario.values import Length, NotNegative, Point, SmallLength, Within


class Door(Section):
    """An opening in a wall, as high as the wall, with a leaf or without."""

    at: NotNegative
    """Start of the opening, metres along the wall from its first point."""
    width: Length = 0.9
    """Width of the opening, metres."""
    angle: Annotated[float, Within(-3.1416, 3.1416, "radians", "degrees", pi / 180.0)] | None = None
    """Opening angle of the leaf, radians: 0 is closed, positive opens to the left of the wall in its direction,
    negative to the right. Without it there is no leaf."""
    hinge: Literal["begin", "end"] = "begin"
    """Side of the opening with the hinge of the leaf."""
    leaf: SmallLength = 0.04
    """Thickness of the leaf, metres."""

    @property
    def end(self) -> float:
        """End of the opening, metres along the wall."""
        return self.at + self.width


@dataclass(frozen=True, slots=True)
class WallSection:
    """A straight section of a wall; ``begin`` is the distance along the wall from its first point, metres."""

    T_map_section: Pose2D
    """Pose of the section's first point; x along the wall."""
    begin: float
    length: float

    def holds(self, door: Door) -> bool:
        """Return True if the whole opening lies in this section."""
        return self.begin - 1e-9 <= door.at and door.end <= self.begin + self.length + 1e-9

    def solid(self, low: float, high: float, width: float, top: float) -> Prism:
        """Make the wall between two positions, metres from this section's first point."""
        T = self.T_map_section
        middle = T @ Pose2D((low + high) / 2.0)
        return Prism(rectangle((middle.x, middle.y), high - low, width, T.theta), 0.0, top)


class Wall(Section):
    """A polyline along the middle of a wall with this thickness."""

    points: tuple[Point, ...] = Field(min_length=2)
    """Corners, map frame, metres."""
    closed: bool = False
    """True if the wall continues from the last point to the first."""
    thickness: SmallLength = 0.1
    """Thickness, metres."""
    height: Annotated[Length, Within(0.0, 100.0, "m", "mm", 1e-3)] = 1.0
    """Height, metres."""
    doors: tuple[Door, ...] = ()
    """Openings, in any order."""

    def prisms(self) -> Iterator[Prism]:
        """Yield the solid parts of each section, half a thickness longer at its ends so that corners are filled.

        The leaves of all doors follow.
        """
        for section in self._sections():
            openings = [place - section.begin for door in self._doors_in(section) for place in (door.at, door.end)]
            ends = [-self.thickness / 2, *openings, section.length + self.thickness / 2]
            for low, high in zip(ends[::2], ends[1::2], strict=True):
                if high > low:
                    yield section.solid(low, high, self.thickness, self.height)
        yield from self.leaves()

    def leaves(self) -> Iterator[Prism]:
        """Yield the leaves of the doors only."""
        for section in self._sections():
            for door in self._doors_in(section):
                if door.angle is not None:
                    yield self._leaf(section, door, door.angle)

    def _doors_in(self, section: WallSection) -> list[Door]:
        return sorted((door for door in self.doors if section.holds(door)), key=lambda door: door.at)

    def _sections(self) -> list[WallSection]:
        ends = [*self.points, self.points[0]] if self.closed else self.points
        lengths = [hypot(x1 - x0, y1 - y0) for (x0, y0), (x1, y1) in pairwise(ends)]
        yaws = [float(np.arctan2(y1 - y0, x1 - x0)) for (x0, y0), (x1, y1) in pairwise(ends)]
        begins = accumulate(lengths, initial=0.0)
        return [
            WallSection(Pose2D(x, y, yaw), begin, length)
            for (x, y), yaw, begin, length in zip(ends, yaws, begins, lengths, strict=False)
        ]

    def _leaf(self, section: WallSection, door: Door, angle: float) -> Prism:
        """Make a leaf on the face of the wall that it opens to, or in its middle if it is closed."""
        hinge, swing = (door.at, angle) if door.hinge == "begin" else (door.end, pi - angle)
        T_map_hinge = section.T_map_section @ Pose2D(
            hinge - section.begin, float(np.sign(angle)) * self.thickness / 2.0, swing
        )
        middle = T_map_hinge @ Pose2D(door.width / 2.0)
        return Prism(rectangle((middle.x, middle.y), door.width, door.leaf, T_map_hinge.theta), 0.0, self.height)

    @model_validator(mode="after")
    def _doors_fit(self) -> Self:
        sections = self._sections() if self.doors else []
        for door in self.doors:
            if not any(section.holds(door) for section in sections):
                parts = ", ".join(f"{s.begin:.4g} to {s.begin + s.length:.4g}" for s in sections)
                raise ValueError(
                    f"the door from {door.at:g} m to {door.end:g} m fits into no straight part of the wall: {parts} m"
                )
        for first, second in pairwise(sorted(self.doors, key=lambda door: door.at)):
            if second.at < first.end:
                raise ValueError(f"the doors at {first.at:g} m and at {second.at:g} m of the wall overlap")
        return self
