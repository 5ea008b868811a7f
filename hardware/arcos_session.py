"""The dialogue with an ARCOS robot: finds it on the line, opens it, asks for its settings, closes it."""

import logging
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, Literal

from hardware import DecodeError
from hardware.arcos.commands import BAUDS, Command, CommandId
from hardware.arcos.config_packet import AUTOBAUD_SWITCH, CONFIG_PACKET, ArcosConfig
from hardware.arcos.model import SYNC2, Identity
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.arcos.sip import is_sip, is_standing
from hardware.serial_port import BITS_PER_BYTE, NoDevice, PortLost, SerialPort
from slam.errors import RobotError

_LOG: Final = logging.getLogger("hopslam.p3dx")
_BAUD_SEARCH: Final = (9600, 38400, 19200, 115200, 57600)
_FAST_BAUD: Final = 38400
_ANSWER: Final = 0.4
"""Seconds within which a robot answers: a cycle and a long report at 9600 baud."""
_LOOK: Final = 0.1
"""Seconds between two looks whether the program is leaving."""
_SENT: Final = 0.05
"""Seconds after which a command has left, which a change of the bit rate would spoil: 9 bytes are 10 ms at 9600."""
_BRAKING: Final = 2.5
"""Seconds within which a robot stands that was told to stop."""
_TRIES: Final = 4
_ROUNDS: Final = 3


@dataclass(frozen=True, slots=True)
class ReceivedPacket:
    """A packet's data, and the time when its first byte began to come, seconds of ``time.monotonic``."""

    data: bytes
    stamp: float


class ArcosLine:
    """Commands out, packets in, over a port; waiting ends with PortLost once ``leaving`` is set."""

    def __init__(self, port: SerialPort, leaving: threading.Event) -> None:
        self.port = port
        self._leaving = leaving
        self._decoder = PacketDecoder()
        self._began = self._heard_at = 0.0
        self.report_when_found_open: ReceivedPacket | None = None
        """Last report of a robot that was found open, standing again; it has counted its travel all the time."""

    @property
    def refused(self) -> Sequence[bytes]:
        """Data of the newest packets whose checksums were wrong."""
        return self._decoder.refused

    def send(self, command: Command) -> None:
        """Write one command."""
        self.port.write(encode_packet(command.encode()))

    def receive(self, timeout: float) -> list[ReceivedPacket]:
        """Return the packets that are whole now; none when nothing comes within ``timeout`` seconds."""
        pending, gap = self._decoder.pending, self.port.longest_gap
        data = self.port.read(min(timeout, gap) if pending else timeout)
        now = time.monotonic()
        if data:
            packets, self._heard_at = self._decoder.feed(data), now
        else:
            packets = self._decoder.flush() if now - self._heard_at >= gap else []
        if not pending:
            on_the_wire = len(data) * BITS_PER_BYTE / self.port.baud if self.port.has_baud else 0.0
            self._began = now - on_the_wire
        arrivals = []
        for packet in packets:
            arrivals.append(ReceivedPacket(packet, self._began))
            self._began = now
        return arrivals

    def wait_for(self, wanted: Callable[[bytes], bool], timeout: float = _ANSWER) -> bytes | None:
        """Return the first wanted packet that comes in time; others are dropped."""
        until = time.monotonic() + timeout
        while (left := until - time.monotonic()) > 0.0:
            if self._leaving.is_set():
                raise PortLost(f"{self.port.url}: given up")
            for arrival in self.receive(min(left, _LOOK)):
                if wanted(arrival.data):
                    return arrival.data
        return None

    def ask(self, command: Command, wanted: Callable[[bytes], bool], tries: int) -> bytes | None:
        """Send a command until a wanted packet comes; None when none does after so many tries."""
        for _ in range(tries):
            self.send(command)
            answer = self.wait_for(wanted)
            if answer is not None:
                return answer
        return None

    def drain(self) -> None:
        """Drop what is still coming, for a short while: a robot that was left open never pauses."""
        until = time.monotonic() + 0.2
        while self.port.read(0.05) and time.monotonic() < until:
            pass
        self._decoder = PacketDecoder()


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
    """Return the settings in the robot's FLASH; those that it does not say are those of ``otherwise``, with a warning.

    A packet whose checksum is wrong is believed when it comes twice alike. RobotError when nothing comes and there is
    nothing else to take.
    """
    packet = _config_packet(line)
    config = ArcosConfig() if packet is None else ArcosConfig.decode(packet)
    if config.watchdog or otherwise is None:
        if packet is None:
            raise RobotError(f"{line.port.url}: the robot does not say its settings (CONFIG)")
        return config
    config = otherwise if packet is None else ArcosConfig.decode(packet, otherwise)
    if config.watchdog:
        _LOG.warning(
            "%s: the robot does not say its settings (CONFIG); hardware.settings is believed: a watchdog of %g s",
            line.port.url,
            config.watchdog,
        )
    return config


def _config_packet(line: ArcosLine) -> bytes | None:
    """Ask for CONFIGpac, and return it; None when none comes."""
    for _ in range(_TRIES):
        line.send(Command(CommandId.CONFIG, 1))
        packet = line.wait_for(lambda data: data[0] == CONFIG_PACKET, 2.0 * _ANSWER)
        if packet is not None:
            return packet
        damaged = [data for data in line.refused if data[0] == CONFIG_PACKET]
        if damaged and damaged.count(damaged[-1]) > 1:
            _LOG.warning("%s: CONFIG has a wrong checksum, but comes twice alike: it is believed", line.port.url)
            return damaged[-1]
    return None


def speed_up(line: ArcosLine, config: ArcosConfig) -> None:
    """Change to a bit rate that has room for every report, where the robot allows it; back again when it fails."""
    slow = line.port.baud
    if config.autobaud != AUTOBAUD_SWITCH or not line.port.has_baud or slow >= _FAST_BAUD:
        return
    line.send(Command(CommandId.HOSTBAUD, BAUDS.index(_FAST_BAUD)))
    time.sleep(_SENT)
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
    """Send SYNC0, SYNC1 and SYNC2, each echoed, or close a robot that was left open; None when none answers.

    STOP comes first: for a robot that was left open SYNC0 is PULSE, upon which it may take up its last velocity.
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
            time.sleep(_SENT)
            return "closed"
        if number == SYNC2:
            with suppress(DecodeError):
                return Identity.decode(answer)
    return None


def _ask(line: ArcosLine, number: int) -> bytes | None:
    return line.ask(Command(number), lambda data: data[0] == number or is_sip(data), tries=2)
