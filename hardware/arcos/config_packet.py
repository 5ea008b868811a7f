"""CONFIGpac: the settings in the robot's FLASH.

Layout: ArRobotConfigPacketReader::packetHandler, AriaCoda. Packets of older firmware end early.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import radians
from typing import Any, Final

from hardware import DecodeError
from hardware.arcos.fields import FieldReader, number, number_fields

CONFIG_PACKET: Final = 0x20
AUTOBAUD_SWITCH: Final = 2
"""The value of ``autobaud`` that lets a client change the bit rate."""
_DEG: Final = radians(1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ArcosConfig:
    """The settings, in the order of the packet; SI units and radians, volts for batteries.

    Settings that the packet leaves out are 0 or empty. Strings end with a NUL.
    """

    robot_type: str = ""
    subtype: str = ""
    serial_number: str = ""
    reserved: int = number("B")
    top_angular: float = number("H", _DEG)
    """Upper limit of SETRV, rad/s; the other ``top`` fields are the upper limits of similar commands."""
    top_linear: float = number("H", 0.001)
    top_angular_acceleration: float = number("H", _DEG)
    top_acceleration: float = number("H", 0.001)
    pwm_max: int = number("H")
    name: str = ""
    sip_cycle: float = number("B", 0.001)
    """Seconds."""
    host_baud: int = number("B")
    """Index into ``BAUDS``."""
    aux1_baud: int = number("B")
    gripper: int = number("H")
    front_sonar: int = number("H")
    rear_sonar: int = number("B")
    low_battery: float = number("H", 0.1)
    rev_count: int = number("H")
    watchdog: float = number("H", 0.001)
    """Seconds without a command after which the robot stops; 0 means never."""
    extra_packets: int = number("B")
    stall_value: int = number("H")
    stall_count: int = number("H")
    joystick_linear: float = number("H", 0.001)
    joystick_angular: float = number("H", _DEG)
    max_angular: float = number("H", _DEG)
    max_linear: float = number("H", 0.001)
    angular_acceleration: float = number("H", _DEG)
    angular_deceleration: float = number("H", _DEG)
    angular_kp: int = number("H")
    angular_kv: int = number("H")
    angular_ki: int = number("H")
    acceleration: float = number("H", 0.001)
    deceleration: float = number("H", 0.001)
    linear_kp: int = number("H")
    linear_kv: int = number("H")
    linear_ki: int = number("H")
    front_bumpers: int = number("B")
    """Number of segments."""
    rear_bumpers: int = number("B")
    charger: int = number("B")
    sonar_cycle: float = number("B", 0.001)
    autobaud: int = number("B")
    gyro: int = number("B")
    drift: int = number("h")
    aux2_baud: int = number("B")
    aux3_baud: int = number("B")
    ticks_per_metre: float = number("H", 1000.0)
    """Ticks of the wheel encoders per metre; the packet has whole ticks per millimetre."""
    shutdown_voltage: float = number("H", 0.1)
    firmware: str = ""
    gyro_clockwise: int = number("H")
    gyro_counter_clockwise: int = number("H")
    kinematics_delay: float = number("B", 0.001)

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
    def decode(cls, data: bytes, otherwise: ArcosConfig | None = None) -> ArcosConfig:
        """Read the data of a packet, which may end after any field; DecodeError for another packet.

        Fields that the packet leaves out are taken from ``otherwise``.
        """
        if data[0] != CONFIG_PACKET:
            raise DecodeError(f"packet {data[0]:#04x} has no configuration")
        reader = FieldReader(data[1:])
        values: dict[str, Any] = {}
        for item in _LAYOUT:
            if isinstance(item, str) and reader.left:
                values[item] = reader.take_string()
            elif not isinstance(item, str) and reader.left >= item.size:
                values[item.name] = reader.take(item)
            else:
                break
        return replace(otherwise or cls(), **values)


_NUMBERS: Final = {field.name: field for field in number_fields(ArcosConfig)}
_LAYOUT: Final = tuple(_NUMBERS.get(field.name, field.name) for field in fields(ArcosConfig))
"""Fields of the packet in order; a name without a number is a string."""
