"""The dialogue with an ARCOS robot: find it on the line, open it, read its settings, close it."""

import logging
import time
from contextlib import suppress
from typing import Final, Literal

from hardware import DecodeError
from hardware.arcos.commands import BAUDS, Command, CommandId
from hardware.arcos.config_packet import AUTOBAUD_SWITCH, CONFIG_PACKET, ArcosConfig
from hardware.arcos.model import SYNC2, Identity
from hardware.arcos.sip import is_sip, is_standing
from hardware.arcos_line import ANSWER, ArcosLine, ReceivedPacket
from hardware.serial_port import NoDevice
from slam.errors import RobotError

_LOG: Final = logging.getLogger("hopslam.p3dx")
_BAUD_SEARCH: Final = (9600, 38400, 19200, 115200, 57600)
_FAST_BAUD: Final = 38400
_SENDING_TIME: Final = 0.05
"""Seconds until a command has left the port, before the bit rate may change: 9 bytes take 10 ms at 9600 baud."""
_BRAKING: Final = 2.5
"""Seconds within which a robot comes to rest after a stop command."""
_TRIES: Final = 4
_ROUNDS: Final = 3


def connect_robot(line: ArcosLine) -> Identity:
    """Find the robot's bit rate, close it if a dead client left it open, and open it; RobotError when none answers."""
    bauds = _BAUD_SEARCH if line.port.has_baud else (line.port.baud,)
    for _ in range(_ROUNDS):
        for baud in bauds:
            line.port.baud = baud
            line.drain()
            answer = _synchronise(line)
            if isinstance(answer, Identity):
                if line.ask(Command(CommandId.OPEN, 1), is_sip, _TRIES) is None:
                    reason = "the robot answers, but reports nothing once opened; switch it off and on"
                    raise RobotError(f"{line.port.url}: {reason}")
                return answer
            if answer == "closed":
                break  # it is back at the bit rate of its FLASH: search again
    tried = f" at {', '.join(map(str, bauds))} baud" if line.port.has_baud else ""
    raise NoDevice(f"{line.port.url}: no ARCOS robot answers{tried}; is it switched on, and its cable right?")


def read_config(line: ArcosLine, otherwise: ArcosConfig | None = None) -> ArcosConfig:
    """Return the settings in the robot's FLASH; missing ones are taken from ``otherwise``, with a warning.

    A packet with a wrong checksum is accepted if it arrives twice alike. RobotError if none arrives and ``otherwise``
    is None.
    """
    packet = _config_packet(line)
    config = ArcosConfig() if packet is None else ArcosConfig.decode(packet)
    if config.watchdog or otherwise is None:
        if packet is None:
            raise RobotError(f"{line.port.url}: the robot does not report its settings (CONFIG)")
        return config
    config = otherwise if packet is None else ArcosConfig.decode(packet, otherwise)
    if config.watchdog:
        _LOG.warning(
            "%s: the robot does not report its settings (CONFIG); hardware.settings is used: a watchdog of %g s",
            line.port.url,
            config.watchdog,
        )
    return config


def _config_packet(line: ArcosLine) -> bytes | None:
    """Request CONFIGpac, and return it; None if none arrives."""
    for _ in range(_TRIES):
        line.send(Command(CommandId.CONFIG, 1))
        packet = line.wait_for(lambda data: data[0] == CONFIG_PACKET, 2.0 * ANSWER)
        if packet is not None:
            return packet
        damaged = [data for data in line.refused if data[0] == CONFIG_PACKET]
        if damaged and damaged.count(damaged[-1]) > 1:
            _LOG.warning("%s: CONFIG has a wrong checksum, but arrived twice alike, and is used", line.port.url)
            return damaged[-1]
    return None


def speed_up(line: ArcosLine, config: ArcosConfig) -> None:
    """Change to a bit rate that is fast enough for every report, if the robot allows it; change back on failure."""
    slow = line.port.baud
    if config.autobaud != AUTOBAUD_SWITCH or not line.port.has_baud or slow >= _FAST_BAUD:
        return
    line.send(Command(CommandId.HOSTBAUD, BAUDS.index(_FAST_BAUD)))
    time.sleep(_SENDING_TIME)
    line.port.baud = _FAST_BAUD
    line.send(Command(CommandId.PULSE))
    if line.wait_for(is_sip, 0.9) is None:
        line.port.baud = slow


def disconnect_robot(line: ArcosLine) -> None:
    """Stop the robot, take the power from its motors, and close it."""
    line.send(Command(CommandId.STOP))
    line.send(Command(CommandId.ENABLE, 0))
    line.send(Command(CommandId.CLOSE, 1))


def _synchronise(line: ArcosLine) -> Identity | Literal["closed"] | None:
    """Send SYNC0, SYNC1 and SYNC2, each echoed, or close a robot that was left open; None if none answers.

    STOP comes first: a robot that was left open takes SYNC0 as PULSE, and might resume its last velocity.
    """
    line.send(Command(CommandId.STOP))
    for number in (0, 1, SYNC2):
        answer = _ask(line, number)
        if answer is None:
            return None
        if is_sip(answer):
            standing = line.wait_for(is_standing, _BRAKING)
            line.report_when_found_open = ReceivedPacket(standing or answer, time.monotonic())
            line.send(Command(CommandId.CLOSE, 1))
            time.sleep(_SENDING_TIME)
            return "closed"
        if number == SYNC2:
            with suppress(DecodeError):
                return Identity.decode(answer)
    return None


def _ask(line: ArcosLine, number: int) -> bytes | None:
    return line.ask(Command(number), lambda data: data[0] == number or is_sip(data), tries=2)
