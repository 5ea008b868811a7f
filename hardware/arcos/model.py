"""The robot's model: its answer to SYNC2, and the units of its reports, which its subclass decides."""

from __future__ import annotations

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
        """Read the data of a packet; DecodeError when it is another one."""
        strings = data[1:].split(b"\0")
        if data[0] != SYNC2 or len(strings) < 3 or not data.isascii():
            raise DecodeError("not the three strings that answer SYNC2")
        return cls(*(text.decode("ascii") for text in strings[:3]))


@dataclass(frozen=True, slots=True)
class ArcosUnits:
    """SI units for one unit of a report (params/*.p of Aria); speeds in mm/s and ranges in mm on every P3-DX."""

    distance: float
    """Metres for one unit of x and y (DistConvFactor)."""
    angle: float = 2.0 * pi / 4096
    """Radians for one unit of theta (AngleConvFactor)."""
    half_track: float = 1.0 / 0.0056 / 1000.0
    """Metres that a wheel rolls for each radian of turning (DiffConvFactor); 2 x 178.6 mm, wider than the wheels
    stand."""

    @property
    def wrap(self) -> float:
        """Metres after which x and y, counted in 15 bits, begin anew."""
        return 0x8000 * self.distance


SONAR_REACH: Final = 5.0
"""Reading of a transducer without an echo, metres."""
P3DX: Final = ArcosUnits(distance=0.485e-3)
P3DX_SH: Final = ArcosUnits(distance=1.0e-3)
_BY_SUBCLASS: Final = {"p3dx-sh": P3DX_SH, "p3dx": P3DX}


def units_of(subclass: str) -> ArcosUnits | None:
    """Return the units of the robot that gives itself this subclass; None for no P3-DX."""
    name = subclass.lower()
    return next((units for known, units in _BY_SUBCLASS.items() if name.startswith(known)), None)
