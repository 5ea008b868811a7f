"""The robot's model: its answer to SYNC2, and the units of its reports, which its subclass decides."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import pi
from typing import Final

from hardware import DecodeError

SYNC2: Final = 2


@dataclass(frozen=True, slots=True)
class Identity:
    """The three strings that answer SYNC2, of at most 19 ASCII characters each (Player keeps them in char[20])."""

    name: str
    robot_class: str
    subclass: str

    def encode(self) -> bytes:
        """Return the data of the packet."""
        strings = (self.name, self.robot_class, self.subclass)
        return bytes([SYNC2]) + b"".join(text.encode("ascii") + b"\0" for text in strings)

    @classmethod
    def decode(cls, data: bytes) -> Identity:
        """Read the data of a packet; DecodeError for another packet."""
        strings = data[1:].split(b"\0")
        if data[0] != SYNC2 or len(strings) < 3 or not data.isascii():
            raise DecodeError("not the three strings that answer SYNC2")
        return cls(*(text.decode("ascii") for text in strings[:3]))


@dataclass(frozen=True, slots=True)
class ArcosUnits:
    """SI values of one unit in a report; commands are in mm/s and degrees on every robot."""

    distance: float
    """Metres per unit of x and y (DistConvFactor)."""
    half_track: float
    """Metres that a wheel rolls per radian of turning (1 / DiffConvFactor); larger than half the wheels' distance."""
    speed: float = 1e-3
    """Metres per second for one unit of a wheel's speed (VelConvFactor)."""
    angle: float = 2.0 * pi / 4096
    """Radians per unit of theta (AngleConvFactor)."""

    @property
    def wrap(self) -> float:
        """Metres after which x and y, counted in 15 bits, wrap."""
        return 0x8000 * self.distance


SONAR_REACH: Final = 5.0
"""Reading of a transducer without an echo, metres."""
_DX_HALF_TRACK: Final = 1e-3 / 0.0056
_AT_HALF_TRACK: Final = 1e-3 / 0.0034
_AMIGO_HALF_TRACK: Final = 1e-3 / 0.011
_PEOPLE_HALF_TRACK: Final = 1e-3 / 0.006
P3DX: Final = ArcosUnits(0.485e-3, _DX_HALF_TRACK)
P3DX_SH: Final = ArcosUnits(1.0e-3, _DX_HALF_TRACK)
UNITS: Final = {
    "p3dx": P3DX,
    "p3dx-sh": P3DX_SH,
    "p3at": ArcosUnits(0.465e-3, _AT_HALF_TRACK),
    "p3at-sh": ArcosUnits(1.0e-3, _AT_HALF_TRACK),
    "amigo": ArcosUnits(0.5083e-3, _AMIGO_HALF_TRACK, speed=0.6154e-3),
    "amigo-sh": ArcosUnits(1.0e-3, _AMIGO_HALF_TRACK),
    "perfpb": ArcosUnits(0.485e-3, _PEOPLE_HALF_TRACK),
    "perfpb+": ArcosUnits(0.485e-3, _PEOPLE_HALF_TRACK),
    "peoplebot-sh": ArcosUnits(1.0e-3, _PEOPLE_HALF_TRACK),
}
"""Units by subclass: P3-DX, P3-AT, AmigoBot and PeopleBot (AriaCoda, params/*.p)."""
_WITH_LASER: Final = re.compile(r"(.+?)-(?:lms|tim|utm|urg|s3)\w*")
"""Subclass of a robot whose parameter file names its laser: p3dx-sh-lms500."""


def units_of(subclass: str) -> ArcosUnits | None:
    """Return the units of the robot with this subclass; None if they are unknown."""
    name = subclass.lower()
    with_laser = _WITH_LASER.fullmatch(name)
    return UNITS.get(with_laser[1] if with_laser else name)
