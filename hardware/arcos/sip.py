"""The standard server information packet (SIP): the robot's report of itself, sent every cycle.

Layout: ArRobot::processMotorPacket and the functions after it, AriaCoda.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Any, Final

from hardware import DecodeError
from hardware.arcos.fields import Field, FieldReader
from hardware.arcos.model import ArcosUnits

_STOPPED, _MOVING = 0x32, 0x33
_IDS: Final = range(0x30, 0x35)
_SONAR: Final = (Field("index", "B"), Field("range", "H", 0.001))
_LEGACY: Final = (Field("gripper", "B"), Field("analog_port", "B"), Field("analog", "B"))
_DIGITAL: Final = (Field("digital_in", "B"), Field("digital_out", "B"))
_TAIL: Final = (
    Field("fine_battery", "H", 0.1),
    Field("charge_state", "B"),
    Field("turning", "h", radians(0.1)),
    Field("faults", "H"),
    Field("lateral", "h", 0.001),
    Field("temperature", "b"),
    Field("charge", "B"),
    Field("time", "I", 1e-6),
    Field("flags3", "I"),
)
_MOTORS_ENABLED, _E_STOP = 1 << 0, 1 << 5


def _head(units: ArcosUnits) -> tuple[Field, ...]:
    return (
        Field("x", "H", units.distance),
        Field("y", "H", units.distance),
        Field("theta", "h", units.angle),
        Field("left", "h", 0.001),
        Field("right", "h", 0.001),
        Field("battery", "B", 0.1),
        Field("left_contacts", "B"),
        Field("right_contacts", "B"),
        Field("control", "h"),
        Field("flags", "H"),
        Field("compass", "B"),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Sip:
    """One report; the fields after ``digital_out`` are None where the robot's firmware leaves them out."""

    moving: bool = False
    x: float = 0.0
    """Metres, modulo ``ArcosUnits.wrap``."""
    y: float = 0.0
    theta: float = 0.0
    """Radians."""
    left: float = 0.0
    """Speed of the left wheel, m/s."""
    right: float = 0.0
    battery: float = 0.0
    """Volts."""
    left_contacts: int = 0
    """Contact bits: 0 for a stalled left wheel, 1 and up for the rear bumpers."""
    right_contacts: int = 0
    """Contact bits: 0 for a stalled right wheel, 1 and up for the front bumpers."""
    control: int = 0
    flags: int = 0
    compass: int = 0
    sonar: tuple[tuple[int, float], ...] = ()
    """(transducer, metres) for each that has a new reading."""
    gripper: int = 0
    analog_port: int = 0
    analog: int = 0
    digital_in: int = 0
    digital_out: int = 0
    fine_battery: float | None = None
    """Volts."""
    charge_state: int | None = None
    turning: float | None = None
    """rad/s."""
    faults: int | None = None
    lateral: float | None = None
    """m/s."""
    temperature: int | None = None
    """Degrees Celsius."""
    charge: int | None = None
    """Per cent."""
    time: float | None = None
    """The robot's clock, seconds."""
    flags3: int | None = None

    @property
    def stalled(self) -> bool:
        """True while a wheel cannot turn as it should."""
        return bool((self.left_contacts | self.right_contacts) & 1)

    @property
    def front_bumpers(self) -> int:
        """A bit for each segment, the first in bit 0."""
        return self.right_contacts >> 1

    @property
    def rear_bumpers(self) -> int:
        """A bit for each segment, the first in bit 0."""
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
        """Return the data of the packet; x and y count on in 16 bits, which readers of 15 and of 12 bits understand."""
        wrapped = {"x": round(self.x / units.distance) & 0xFFFF, "y": round(self.y / units.distance) & 0xFFFF}
        data = bytes([_MOVING if self.moving else _STOPPED])
        data += b"".join(wrapped[f.name].to_bytes(2, "little") for f in _head(units)[:2])
        data += b"".join(field.encode(getattr(self, field.name)) for field in _head(units)[2:])
        data += bytes([len(self.sonar)])
        data += b"".join(field.encode(value) for echo in self.sonar for field, value in zip(_SONAR, echo, strict=True))
        data += b"".join(field.encode(getattr(self, field.name)) for field in _LEGACY + _DIGITAL)
        for field in _TAIL:
            value = getattr(self, field.name)
            if value is None:
                break
            data += field.encode(value)
        return data

    @classmethod
    def decode(cls, data: bytes, units: ArcosUnits) -> Sip:
        """Read the data of a packet; DecodeError when it is another one, or ends too early."""
        if data[0] not in _IDS:
            raise DecodeError(f"packet {data[0]:#04x} is no SIP")
        reader = FieldReader(data[1:])
        values: dict[str, Any] = {field.name: reader.take(field) for field in _head(units)}
        values["x"] %= units.wrap
        values["y"] %= units.wrap
        count = reader.take(Field("count", "B"))
        values["sonar"] = tuple(tuple(reader.take(field) for field in _SONAR) for _ in range(int(count)))
        values |= {field.name: reader.take(field) for field in _LEGACY + _DIGITAL}
        for field in _TAIL:
            if reader.left < field.size:
                break
            values[field.name] = reader.take(field)
        return cls(moving=data[0] == _MOVING, **values)


def is_sip(data: bytes) -> bool:
    """Tell whether a packet with these data is a standard SIP."""
    return data[0] in _IDS


def is_standing(data: bytes) -> bool:
    """Tell whether a packet with these data is the SIP of a robot whose motors stand."""
    return data[0] == _STOPPED


def flags(motors_enabled: bool, e_stop: bool) -> int:
    """Return the flags of a SIP."""
    return _MOTORS_ENABLED * motors_enabled | _E_STOP * e_stop
