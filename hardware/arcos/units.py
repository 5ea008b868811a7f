"""What the numbers of a robot's reports mean: the files params/*.p of Aria, of which the subclass chooses one."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Final


@dataclass(frozen=True, slots=True)
class ArcosUnits:
    """SI units for one unit of a report. The speeds are in mm/s and the ranges in mm on every P3-DX."""

    distance: float
    """Metres a unit of x and y (DistConvFactor)."""
    angle: float = 2.0 * pi / 4096
    """Radians a unit of theta (AngleConvFactor)."""
    half_track: float = 1.0 / 0.0056 / 1000.0
    """Metres: a wheel's way for each radian of turning (DiffConvFactor); 2 x 178.6 mm, wider than the wheels stand."""

    @property
    def wrap(self) -> float:
        """x and y are counted in 15 bits, and begin anew after this many metres."""
        return 0x8000 * self.distance


SONAR_REACH: Final = 5.0
"""Metres: what a transducer without an echo reads."""
P3DX: Final = ArcosUnits(distance=0.485e-3)
P3DX_SH: Final = ArcosUnits(distance=1.0e-3)
_BY_SUBCLASS: Final = {"p3dx-sh": P3DX_SH, "p3dx": P3DX}


def units_of(subclass: str) -> ArcosUnits | None:
    """The units of the robot that gives itself this subclass; None for no P3-DX."""
    name = subclass.lower()
    return next((units for known, units in _BY_SUBCLASS.items() if name.startswith(known)), None)
