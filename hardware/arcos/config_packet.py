"""CONFIGpac: the settings in the robot's FLASH.

Layout: ArRobotConfigPacketReader::packetHandler, AriaCoda. Packets of older firmware end early.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Any, Final

from hardware.arcos.fields import Field, FieldReader
from hardware.decode_error import DecodeError

CONFIG_PACKET: Final = 0x20
AUTOBAUD_SWITCH: Final = 2
"""The value of ``autobaud`` that lets a client change the bit rate."""
_DEG: Final = radians(1.0)
_LAYOUT: Final[tuple[Field | str, ...]] = (
    "robot_type",
    "subtype",
    "serial_number",
    Field("reserved", "B"),
    Field("top_angular", "H", _DEG),
    Field("top_linear", "H", 0.001),
    Field("top_angular_acceleration", "H", _DEG),
    Field("top_acceleration", "H", 0.001),
    Field("pwm_max", "H"),
    "name",
    Field("sip_cycle", "B", 0.001),
    Field("host_baud", "B"),
    Field("aux1_baud", "B"),
    Field("gripper", "H"),
    Field("front_sonar", "H"),
    Field("rear_sonar", "B"),
    Field("low_battery", "H", 0.1),
    Field("rev_count", "H"),
    Field("watchdog", "H", 0.001),
    Field("extra_packets", "B"),
    Field("stall_value", "H"),
    Field("stall_count", "H"),
    Field("joystick_linear", "H", 0.001),
    Field("joystick_angular", "H", _DEG),
    Field("max_angular", "H", _DEG),
    Field("max_linear", "H", 0.001),
    Field("angular_acceleration", "H", _DEG),
    Field("angular_deceleration", "H", _DEG),
    Field("angular_kp", "H"),
    Field("angular_kv", "H"),
    Field("angular_ki", "H"),
    Field("acceleration", "H", 0.001),
    Field("deceleration", "H", 0.001),
    Field("linear_kp", "H"),
    Field("linear_kv", "H"),
    Field("linear_ki", "H"),
    Field("front_bumpers", "B"),
    Field("rear_bumpers", "B"),
    Field("charger", "B"),
    Field("sonar_cycle", "B", 0.001),
    Field("autobaud", "B"),
    Field("gyro", "B"),
    Field("drift", "h"),
    Field("aux2_baud", "B"),
    Field("aux3_baud", "B"),
    Field("ticks_per_metre", "H", 1000.0),
    Field("shutdown_voltage", "H", 0.1),
    "firmware",
    Field("gyro_clockwise", "H"),
    Field("gyro_counter_clockwise", "H"),
    Field("kinematics_delay", "B", 0.001),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ArcosConfig:
    """The settings; SI units and radians, volts for batteries. What the packet leaves out is 0 or empty."""

    robot_type: str = ""
    subtype: str = ""
    serial_number: str = ""
    reserved: int = 0
    top_angular: float = 0.0
    """The fastest that SETRV can ask for, rad/s; the other tops alike."""
    top_linear: float = 0.0
    top_angular_acceleration: float = 0.0
    top_acceleration: float = 0.0
    pwm_max: int = 0
    name: str = ""
    sip_cycle: float = 0.0
    """Seconds."""
    host_baud: int = 0
    """An index into ``BAUDS``."""
    aux1_baud: int = 0
    gripper: int = 0
    front_sonar: int = 0
    rear_sonar: int = 0
    low_battery: float = 0.0
    rev_count: int = 0
    watchdog: float = 0.0
    """Seconds without a command after which the robot stops; 0: never."""
    extra_packets: int = 0
    stall_value: int = 0
    stall_count: int = 0
    joystick_linear: float = 0.0
    joystick_angular: float = 0.0
    max_angular: float = 0.0
    max_linear: float = 0.0
    angular_acceleration: float = 0.0
    angular_deceleration: float = 0.0
    angular_kp: int = 0
    angular_kv: int = 0
    angular_ki: int = 0
    acceleration: float = 0.0
    deceleration: float = 0.0
    linear_kp: int = 0
    linear_kv: int = 0
    linear_ki: int = 0
    front_bumpers: int = 0
    """How many segments."""
    rear_bumpers: int = 0
    charger: int = 0
    sonar_cycle: float = 0.0
    autobaud: int = 0
    gyro: int = 0
    drift: int = 0
    aux2_baud: int = 0
    aux3_baud: int = 0
    ticks_per_metre: float = 0.0
    """Of the wheel encoders, of which the packet says whole ticks a millimetre."""
    shutdown_voltage: float = 0.0
    firmware: str = ""
    gyro_clockwise: int = 0
    gyro_counter_clockwise: int = 0
    kinematics_delay: float = 0.0

    def encode(self) -> bytes:
        """The data of the packet."""
        data = bytes([CONFIG_PACKET])
        for item in _LAYOUT:
            if isinstance(item, str):
                data += getattr(self, item).encode("latin-1") + b"\0"
            else:
                data += item.encode(getattr(self, item.name))
        return data

    @classmethod
    def decode(cls, data: bytes) -> ArcosConfig:
        """From the data of a packet, which may end anywhere; Damaged when it is another one."""
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
