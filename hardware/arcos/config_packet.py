"""CONFIGpac: the settings in the robot's FLASH.

Layout: ArRobotConfigPacketReader::packetHandler, AriaCoda. Packets of older firmware end early.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from math import radians
from typing import Any, Final

from hardware import DecodeError
from hardware.arcos.fields import Field, FieldReader

CONFIG_PACKET: Final = 0x20
AUTOBAUD_SWITCH: Final = 2
"""The value of ``autobaud`` that lets a client change the bit rate."""
_DEG: Final = radians(1.0)


def _number(code: str, unit: float = 1) -> Any:
    """Declare a number of the packet: its code in ``struct``, and one unit of it in SI units."""
    return field(default=0 if unit == 1 else 0.0, metadata={"code": code, "unit": unit})


@dataclass(frozen=True, slots=True, kw_only=True)
class ArcosConfig:
    """The settings, in the order of the packet; SI units and radians, volts for batteries.

    Settings that the packet leaves out are 0 or empty. Strings end with a NUL.
    """

    robot_type: str = ""
    subtype: str = ""
    serial_number: str = ""
    reserved: int = _number("B")
    top_angular: float = _number("H", _DEG)
    """The fastest that SETRV can ask for, rad/s; the other tops alike."""
    top_linear: float = _number("H", 0.001)
    top_angular_acceleration: float = _number("H", _DEG)
    top_acceleration: float = _number("H", 0.001)
    pwm_max: int = _number("H")
    name: str = ""
    sip_cycle: float = _number("B", 0.001)
    """Seconds."""
    host_baud: int = _number("B")
    """An index into ``BAUDS``."""
    aux1_baud: int = _number("B")
    gripper: int = _number("H")
    front_sonar: int = _number("H")
    rear_sonar: int = _number("B")
    low_battery: float = _number("H", 0.1)
    rev_count: int = _number("H")
    watchdog: float = _number("H", 0.001)
    """Seconds without a command after which the robot stops; 0: never."""
    extra_packets: int = _number("B")
    stall_value: int = _number("H")
    stall_count: int = _number("H")
    joystick_linear: float = _number("H", 0.001)
    joystick_angular: float = _number("H", _DEG)
    max_angular: float = _number("H", _DEG)
    max_linear: float = _number("H", 0.001)
    angular_acceleration: float = _number("H", _DEG)
    angular_deceleration: float = _number("H", _DEG)
    angular_kp: int = _number("H")
    angular_kv: int = _number("H")
    angular_ki: int = _number("H")
    acceleration: float = _number("H", 0.001)
    deceleration: float = _number("H", 0.001)
    linear_kp: int = _number("H")
    linear_kv: int = _number("H")
    linear_ki: int = _number("H")
    front_bumpers: int = _number("B")
    """Number of segments."""
    rear_bumpers: int = _number("B")
    charger: int = _number("B")
    sonar_cycle: float = _number("B", 0.001)
    autobaud: int = _number("B")
    gyro: int = _number("B")
    drift: int = _number("h")
    aux2_baud: int = _number("B")
    aux3_baud: int = _number("B")
    ticks_per_metre: float = _number("H", 1000.0)
    """Ticks of the wheel encoders; the packet has whole ticks a millimetre."""
    shutdown_voltage: float = _number("H", 0.1)
    firmware: str = ""
    gyro_clockwise: int = _number("H")
    gyro_counter_clockwise: int = _number("H")
    kinematics_delay: float = _number("B", 0.001)

    def encode(self) -> bytes:
        """Return the data of the packet."""
        data = bytes([CONFIG_PACKET])
        for item in _LAYOUT:
            if isinstance(item, str):
                data += getattr(self, item).encode("latin-1") + b"\0"
            else:
                data += item.encode(getattr(self, item.name))
        return data

    @classmethod
    def decode(cls, data: bytes) -> ArcosConfig:
        """Read the data of a packet, which may end anywhere; DecodeError when it is another one."""
        if data[0] != CONFIG_PACKET:
            raise DecodeError(f"packet {data[0]:#04x} has no configuration")
        reader = FieldReader(data[1:])
        values: dict[str, Any] = {}
        for item in _LAYOUT:
            if isinstance(item, str):
                values[item] = reader.take_string()
            elif reader.left >= item.size:
                values[item.name] = reader.take(item)
            else:
                break
        return cls(**values)


_LAYOUT: Final = tuple(Field(f.name, **f.metadata) if f.metadata else f.name for f in fields(ArcosConfig))
"""The fields of the packet one after another; a name alone is that of a string."""
