"""Describes messages of ARCOS; the meaning of a few depends on those before them."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import fields
from math import degrees
from typing import Final

from hardware import DecodeError
from hardware.arcos.commands import Command, CommandId, decode_vel2
from hardware.arcos.config_packet import CONFIG_PACKET, ArcosConfig
from hardware.arcos.encoder_packet import ENCODER_PACKET
from hardware.arcos.model import P3DX_SH, SYNC2, ArcosUnits, Identity, units_of
from hardware.arcos.sip import Sip, is_sip

_SYNC: Final = ("SYNC0", "SYNC1", "SYNC2")


class RobotWords:
    """Describes commands and packets of one robot, in the units of its subclass."""

    def __init__(self) -> None:
        self._open = False
        self._units: ArcosUnits = P3DX_SH

    def of_command(self, data: bytes) -> str:
        """Describe a packet to the robot, its argument as on the wire: mm, degrees, seconds."""
        try:
            command = Command.decode(data)
        except DecodeError as error:
            return f"command {data[0]}: {error}"
        if not self._open and len(data) == 1 and command.id < len(_SYNC):
            return _SYNC[command.id]
        if command.id in (CommandId.OPEN, CommandId.CLOSE):
            self._open = command.id == CommandId.OPEN
        known = command.id in set(CommandId)
        name = CommandId(command.id).name if known else f"command {command.id}"
        if command.id == CommandId.VEL2 and isinstance(command.argument, int):
            left, right = decode_vel2(command.argument)
            return f"{name} left {left:g} m/s, right {right:g} m/s"
        return name if command.argument is None else f"{name} {command.argument!r}"

    def of_packet(self, data: bytes) -> str:
        """Describe a packet from the robot."""
        with suppress(DecodeError):
            if is_sip(data):
                return f"SIP {', '.join(_sip_words(Sip.decode(data, self._units)))}"
            if data[0] == CONFIG_PACKET:
                return f"CONFIG {', '.join(_settings(ArcosConfig.decode(data)))}"
            if data[0] == SYNC2 and len(data) > 1:
                return self._identity(Identity.decode(data))
        if len(data) == 1 and data[0] < len(_SYNC):
            return f"{_SYNC[data[0]]} echoed"
        name = "encoders" if data[0] == ENCODER_PACKET else f"packet {data[0]:#04x}"
        return f"{name}, {len(data) - 1} bytes: {data[1:].hex(' ')}"

    def _identity(self, identity: Identity) -> str:
        self._units = units_of(identity.subclass) or P3DX_SH
        return f"SYNC2: name {identity.name!r}, class {identity.robot_class!r}, subclass {identity.subclass!r}"


def _sip_words(sip: Sip) -> Iterator[str]:
    yield f"x {sip.x:.3f} y {sip.y:.3f} m, theta {degrees(sip.theta):.1f} deg"
    yield f"wheels {sip.left:.3f} {sip.right:.3f} m/s"
    yield f"battery {sip.volts:.1f} V"
    yield "motors on" if sip.motors_enabled else "motors off"
    if sip.e_stop:
        yield "emergency stop"
    if sip.stalled:
        yield "stalled"
    if sip.front_bumpers or sip.rear_bumpers:
        yield f"bumpers front {sip.front_bumpers:05b} rear {sip.rear_bumpers:05b}"
    if sip.sonar:
        yield "sonar " + " ".join(f"{number}:{metres:.2f}" for number, metres in sip.sonar)
    if sip.faults:
        yield f"faults {sip.faults:#06x}"


def _settings(config: ArcosConfig) -> Iterator[str]:
    """Name the settings that are not 0."""
    for field in fields(config):
        value = getattr(config, field.name)
        if value:
            yield f"{field.name} {value:g}" if isinstance(value, float) else f"{field.name} {value}"
