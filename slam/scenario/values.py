"""Values in sections of a scenario: positive numbers, points and poses in SI units and radians."""

from dataclasses import dataclass
from math import pi
from typing import Annotated, Any

from pydantic import AfterValidator, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from slam.config import Section
from slam.pose import Pose2D


@dataclass(frozen=True, slots=True)
class Within:
    """Metadata of an annotated float: the least and the largest plausible value, in ``unit``.

    A number outside the bounds was probably meant in ``wrong_unit``, which is ``factor`` times ``unit``; the error
    shows it converted. The JSON schema has the bounds too.
    """

    low: float
    high: float
    unit: str
    wrong_unit: str
    factor: float

    def check(self, value: float) -> float:
        """Return the value; ValueError if it is out of bounds."""
        if self.low <= value <= self.high:
            return value
        bounds = f"at most {self.high:g}" if self.low >= 0 else f"within {self.low:g} and {self.high:g}"
        meant = f"{value:g} {self.wrong_unit} are {value * self.factor:.4g} {self.unit}"
        raise ValueError(f"{self.unit}, {bounds}; {meant}")

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        shown = handler(schema)
        return shown | {"maximum": self.high} | ({} if "exclusiveMinimum" in shown else {"minimum": self.low})


Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Count = Annotated[int, Field(ge=0, le=1000)]
Length = Annotated[float, Field(gt=0, le=1000)]
"""Size of a thing or a building, metres."""
Angle = Annotated[float, Within(-6.2832, 6.2832, "radians", "degrees", pi / 180.0)]
"""Angle within a turn either way."""
Speed = Annotated[Positive, Within(0.0, 2.2, "m/s", "mm/s", 1e-3)]
"""Speed of a P3-DX, up to MaxVelocity of p3dx-sh.p."""
TurnSpeed = Annotated[Positive, Within(0.0, 8.73, "rad/s", "deg/s", pi / 180.0)]
"""Turning speed of a P3-DX, up to MaxRVelocity of p3dx-sh.p, 500 deg/s."""
SmallLength = Annotated[Positive, Within(0.0, 3.0, "m", "mm", 1e-3)]
"""Length of a part of the robot, of a person, or of a path beside them, metres."""
Coordinate = Annotated[float, Field(ge=-5000, le=5000)]
"""Coordinate in the map frame, metres; up to its bounds, ranges are accurate to a hundredth of a millimetre."""
Point = tuple[Coordinate, Coordinate]
"""x and y in the map frame, metres."""


def ordered_bounds(bounds: tuple[Any, Any]) -> tuple[Any, Any]:
    """Return the bounds; ValueError if the upper one comes first."""
    if bounds[0] > bounds[1]:
        raise ValueError("the lower bound comes first")
    return bounds


Span = Annotated[tuple[Length, Length], AfterValidator(ordered_bounds)]
"""The least and the largest value."""


def millimetres(*values: float) -> tuple[float, ...]:
    """Round lengths in metres to whole millimetres, for readability."""
    return tuple(round(float(value), 3) for value in values)


def readable_point(x: float, y: float) -> Point:
    """Round a point to whole millimetres."""
    return round(float(x), 3), round(float(y), 3)


class Place(Section):
    """A pose in the plane, metres and radians."""

    x: Coordinate = 0.0
    """x, metres."""
    y: Coordinate = 0.0
    """y, metres."""
    theta: Angle = 0.0
    """Counter-clockwise from the x axis, radians."""

    @property
    def pose(self) -> Pose2D:
        """The same pose for computation."""
        return Pose2D(self.x, self.y, self.theta)
