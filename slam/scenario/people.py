"""People who walk through a scenario's world: two legs on a path."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from slam.config import Section
from slam.scenario.quantity import Within
from slam.scenario.values import NotNegative, Point, Positive, Small


class Person(Section):
    """Somebody who walks from way-point to way-point, for ever, and stands still while the robot is in the way."""

    waypoints: tuple[Point, ...] = Field(min_length=1)
    """Metres, map frame; one alone: a person who stands there."""
    closed: bool = False
    """From the last way-point on to the first; else the same way back."""
    speed: Annotated[Positive, Within(0.0, 5.0, "m/s", "mm/s", 1e-3)] = 1.0
    """m/s."""
    pause: NotNegative = 0.0
    """Seconds at each way-point."""
    start: NotNegative = 0.0
    """Metres of the path that are behind this person when the run begins."""
    leg_radius: Small = 0.06
    """Metres."""
    stance: Small = 0.2
    """Between the middles of the legs, across the path, metres."""
    stride: Small = 0.7
    """Between two footprints of different legs, along the path, metres."""
    keep: Annotated[NotNegative, Within(0.0, 20.0, "m", "mm", 1e-3)] = 0.8
    """This person stops while the middle of the robot is nearer than this ahead, metres. Their feet are up
    to half a stride ahead of their own middle."""
