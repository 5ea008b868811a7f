"""What a generator makes."""

from __future__ import annotations

from dataclasses import dataclass

from slam.scenario.people import Person
from slam.scenario.values import Place, Point
from slam.scenario.world_plan import World


@dataclass(frozen=True, slots=True)
class Site:
    """A world, and how it is to be visited: nothing stands nearer than 0.3 m to the way from ``start`` on."""

    world: World
    start: Place
    waypoints: tuple[Point, ...]
    people: tuple[Person, ...] = ()


def millimetres(*values: float) -> tuple[float, ...]:
    """Rounded: what is generated is written out, and read by people."""
    return tuple(round(float(value), 3) for value in values)
