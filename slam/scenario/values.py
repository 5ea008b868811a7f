"""What the sections of a scenario are made of: positive numbers, points and poses in SI units and radians."""

from __future__ import annotations

from math import pi
from typing import Annotated

from pydantic import AfterValidator, Field

from slam.config import Section
from slam.pose import Pose2D
from slam.scenario.quantity import Within

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Count = Annotated[int, Field(ge=0, le=1000)]
Length = Annotated[float, Field(gt=0, le=1000)]
"""Of a thing or a building, metres."""
Angle = Annotated[float, Within(-6.2832, 6.2832, "radians", "degrees", pi / 180.0)]
"""Within a turn either way."""
Speed = Annotated[Positive, Within(0.0, 2.2, "m/s", "mm/s", 1e-3)]
"""No P3-DX is faster: MaxVelocity of p3dx-sh.p."""
TurnSpeed = Annotated[Positive, Within(0.0, 8.73, "rad/s", "deg/s", pi / 180.0)]
"""No P3-DX turns faster: MaxRVelocity of p3dx-sh.p, 500 deg/s."""
Small = Annotated[Positive, Within(0.0, 3.0, "m", "mm", 1e-3)]
"""A measure of the robot, of a person, or of a way beside them."""
Coordinate = Annotated[float, Field(ge=-5000, le=5000)]
"""Metres, map frame; so far out, the ranges of a robot are still good to a hundredth of a millimetre."""
Point = tuple[Coordinate, Coordinate]
"""x and y in the map frame, metres."""


def _ordered(bounds: tuple[float, float]) -> tuple[float, float]:
    if bounds[0] > bounds[1]:
        raise ValueError("the lower bound comes first")
    return bounds


Span = Annotated[tuple[Length, Length], AfterValidator(_ordered)]
"""The least and the largest value."""


class Place(Section):
    """A pose in the plane, metres and radians."""

    x: Coordinate = 0.0
    """Metres."""
    y: Coordinate = 0.0
    """Metres."""
    theta: Angle = 0.0
    """Counter-clockwise from the x axis, radians."""

    @property
    def pose(self) -> Pose2D:
        """As a value to compute with."""
        return Pose2D(self.x, self.y, self.theta)
