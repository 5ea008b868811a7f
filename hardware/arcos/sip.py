"""The standard server information packet (SIP): the robot's report of itself, sent every cycle.

Layout: ArRobot::processMotorPacket and the functions after it, AriaCoda.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import radians
from typing import Any, Final

from hardware import DecodeError
from hardware.arcos.fields import Field, FieldReader, number, number_fields
from hardware.arcos.model import ArcosUnits

_STOPPED, _MOVING = 0x32, 0x33
_IDS: Final = range(0x30, 0x35)
_SONAR: Final = (Field("index", "B"), Field("range", "H", 0.001))
_MOTORS_ENABLED, _E_STOP = 1 << 0, 1 << 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Sip:
    """One report; the fields after ``digital_out`` are None if the robot's firmware leaves them out."""

    moving: bool = False
    x: float = 0.0
    """Metres, modulo ``ArcosUnits.wrap``."""
    y: float = 0.0
    theta: float = 0.0
    """Radians."""
    left: float = 0.0
    """Speed of the left wheel, m/s."""
    right: float = 0.0
    battery: float = number("B", 0.1)
    """Volts."""
    left_contacts: int = number("B")
    """Contact bits: 0 for a stalled left wheel, 1 and up for the rear bumpers."""
    right_contacts: int = number("B")
    """Contact bits: 0 for a stalled right wheel, 1 and up for the front bumpers."""
    control: int = number("h")
    flags: int = number("H")
    compass: int = number("B")
    sonar: tuple[tuple[int, float], ...] = ()
    """(transducer, metres) for each that has a new reading."""
    gripper: int = number("B")
    analog_port: int = number("B")
    analog: int = number("B")
    digital_in: int = number("B")
    digital_out: int = number("B")
    fine_battery: float | None = number("H", 0.1, optional=True)
    """Volts."""
    charge_state: int | None = number("B", optional=True)
    turning: float | None = number("h", radians(0.1), optional=True)
    """rad/s."""
    faults: int | None = number("H", optional=True)
    lateral: float | None = number("h", 0.001, optional=True)
    """m/s."""
    temperature: int | None = number("b", optional=True)
    """Degrees Celsius."""
    charge: int | None = number("B", optional=True)
    """Per cent."""
    time: float | None = number("I", 1e-6, optional=True)
    """The robot's clock, seconds."""
    flags3: int | None = number("I", optional=True)

    @property
    def stalled(self) -> bool:
        """True while a wheel cannot turn as it should."""
        return bool((self.left_contacts | self.right_contacts) & 1)

    @property
    def volts(self) -> float:
        """Voltage of the battery, from the field of the finest resolution."""
        return self.battery if self.fine_battery is None else self.fine_battery

    @property
    def front_bumpers(self) -> int:
        """One bit per segment, the first in bit 0."""
        return self.right_contacts >> 1

    @property
    def rear_bumpers(self) -> int:
        """One bit per segment, the first in bit 0."""
        return self.left_contacts >> 1

    @property
    def motors_enabled(self) -> bool:
        """True while the motors have power."""
        return bool(self.flags & _MOTORS_ENABLED)

    @property
    def e_stop(self) -> bool:
        """True while the emergency stop is pressed."""
        return bool(self.flags & _E_STOP)

    def encode(self, units: ArcosUnits) -> bytes:
        """Return the data of the packet.

        The fields x and y are 16-bit counters; clients that use only the low 15 or 12 bits can decode them too.
        """
        data = bytes([_MOVING if self.moving else _STOPPED])
        data += b"".join((round(v / units.distance) & 0xFFFF).to_bytes(2, "little") for v in (self.x, self.y))
        data += b"".join(field.encode(getattr(self, field.name)) for field in _motion_fields(units))
        data += b"".join(field.encode(getattr(self, field.name)) for field in _HEAD)
        data += bytes([len(self.sonar)])
        data += b"".join(field.encode(value) for echo in self.sonar for field, value in zip(_SONAR, echo, strict=True))
        data += b"".join(field.encode(getattr(self, field.name)) for field in _PORTS)
        for field in _TAIL:
            value = getattr(self, field.name)
            if value is None:
                break
            data += field.encode(value)
        return data

    @classmethod
    def decode(cls, data: bytes, units: ArcosUnits) -> Sip:
        """Read the data of a packet; DecodeError for another packet, or one that ends too early."""
        if data[0] not in _IDS:
            raise DecodeError(f"packet {data[0]:#04x} is not a SIP")
        reader = FieldReader(data[1:])
        head = (*_position_fields(units), *_motion_fields(units), *_HEAD)
        values: dict[str, Any] = {field.name: reader.take(field) for field in head}
        values["x"] %= units.wrap
        values["y"] %= units.wrap
        count = reader.take(Field("count", "B"))
        values["sonar"] = tuple(tuple(reader.take(field) for field in _SONAR) for _ in range(int(count)))
        values |= {field.name: reader.take(field) for field in _PORTS}
        for field in _TAIL:
            if reader.left < field.size:
                break
            values[field.name] = reader.take(field)
        return cls(moving=data[0] == _MOVING, **values)


_NUMBERS: Final = number_fields(Sip)
_HEAD, _PORTS, _TAIL = _NUMBERS[:6], _NUMBERS[6:11], _NUMBERS[11:]
"""Fields before the sonar readings, after them, and the optional ones, which begin with ``fine_battery``."""


def _position_fields(units: ArcosUnits) -> tuple[Field, Field]:
    return Field("x", "H", units.distance), Field("y", "H", units.distance)


def _motion_fields(units: ArcosUnits) -> tuple[Field, Field, Field]:
    return Field("theta", "h", units.angle), Field("left", "h", units.speed), Field("right", "h", units.speed)


def is_sip(data: bytes) -> bool:
    """Return True if a packet with these data is a standard SIP."""
    return data[0] in _IDS


def is_standing(data: bytes) -> bool:
    """Return True if a packet with these data is the SIP of a robot whose motors stand still."""
    return data[0] == _STOPPED


def flags(motors_enabled: bool, e_stop: bool, sonar_arrays: Iterable[int] = ()) -> int:
    """Return the flags of a SIP; ``sonar_arrays`` are the numbers, 1 to 4, of the arrays that are on."""
    arrays = sum(1 << number for number in sonar_arrays)
    return _MOTORS_ENABLED * motors_enabled | _E_STOP * e_stop | arrays
