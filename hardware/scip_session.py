"""The dialogue with a SCIP sensor: finds it on the line whatever state it is in, asks, stops scans."""

import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from math import ceil
from typing import Final

from hardware import DecodeError
from hardware.scip.commands import TO_SCIP2, ScanRequest, set_baud
from hardware.scip.frames import FrameDecoder, Lines
from hardware.scip.information import SensorParameters, VersionInfo
from hardware.scip.reply import DATA_LINE, Reply, decode_old_reply, find_reply
from hardware.scip.status import is_ok, status_meaning
from hardware.serial_port import BITS_PER_BYTE, NoDevice, PortLost, SerialPort
from slam.errors import RobotError

_BAUD_SEARCH: Final = (19200, 115200, 57600, 38400, 500000, 750000, 250000)
_ANSWER: Final = 0.5
"""Seconds: an answer comes at the end of a turn, and may stand behind a scan at 115200 baud."""
_LOOK: Final = 0.1
"""Seconds between two looks whether the program is leaving."""
_LAST_ANSWER: Final = 0.3
"""Seconds to wait for the answer to the last QT."""
_TRIES: Final = 3
_SILENCES: Final = 2
"""Questions without an answer after which a bit rate is given up."""
_HEAD: Final = 30
"""Characters of an answer before its data, at most."""
_FILL: Final = 0.9
"""Share of the line that scans may take."""


@dataclass(frozen=True, slots=True)
class RawAnswer:
    """The lines of an answer, and the times when its first and last bytes were read, seconds of ``time.monotonic``."""

    lines: Lines
    began: float
    ended: float


class ScipLine:
    """Commands out, answers in, over a port; waiting ends with PortLost once ``leaving`` is set."""

    def __init__(self, port: SerialPort, leaving: threading.Event) -> None:
        self.port = port
        self._leaving = leaving
        self._decoder = FrameDecoder()
        self._began = self._heard_at = 0.0

    def send(self, command: str) -> None:
        """Write one command."""
        self.port.write(command.encode("ascii") + b"\n")

    def receive(self, timeout: float) -> list[RawAnswer]:
        """Return the answers that are whole now; none when nothing comes within ``timeout`` seconds."""
        pending, gap = self._decoder.pending, self.port.longest_gap
        data = self.port.read(min(timeout, gap) if pending else timeout)
        now = time.monotonic()
        if data:
            self._heard_at = now
        elif now - self._heard_at >= gap:
            self._decoder.flush()
        if not pending:
            self._began = now
        frames = []
        for lines in self._decoder.feed(data):
            frames.append(RawAnswer(lines, self._began, now))
            self._began = now
        return frames

    def ask(self, command: str, timeout: float = _ANSWER) -> Reply | None:
        """Send a command, and wait for the answer with its echo; other answers are dropped. None when none comes."""
        self.send(command)
        return self.wait_for(command, timeout)

    def wait_for(self, command: str, timeout: float) -> Reply | None:
        """Return the answer with this echo; None when none comes."""
        until = time.monotonic() + timeout
        while (left := until - time.monotonic()) > 0.0:
            if self._leaving.is_set():
                raise PortLost(f"{self.port.url}: given up")
            for frame in self.receive(min(left, _LOOK)):
                reply = find_reply(frame.lines) or _old(frame.lines)
                if reply is not None and reply.echo == command:
                    return reply
        return None

    def ask_until_answered(self, command: str) -> Reply:
        """Ask several times; RobotError when the sensor does not answer, or refuses."""
        for _ in range(_TRIES):
            reply = self.ask(command)
            if reply is not None:
                if not is_ok(reply.status):
                    why = status_meaning(command, reply.status)
                    raise RobotError(f"{self.port.url}: the lidar refuses {command}: status {reply.status}, {why}")
                return reply
        raise RobotError(f"{self.port.url}: the lidar does not answer {command}")


def connect_lidar(line: ScipLine, baud: int) -> None:
    """Find the sensor's bit rate, stop what it is doing, bring it to SCIP 2.0, and then to ``baud`` where that helps.

    RobotError when no sensor answers.
    """
    others = [rate for rate in _BAUD_SEARCH if rate != baud]
    bauds = [baud, *others] if line.port.has_baud else [line.port.baud]
    for rate in bauds:
        line.port.baud = rate
        if _silence(line):
            _change_baud(line, baud)
            return
    tried = f" at {', '.join(map(str, bauds))} baud" if line.port.has_baud else ""
    raise NoDevice(f"{line.port.url}: no SCIP sensor answers{tried}; is it powered, and this the right port?")


def identify(line: ScipLine) -> tuple[VersionInfo, SensorParameters]:
    """Ask the sensor for its identity and its abilities."""
    try:
        return VersionInfo.decode(line.ask_until_answered("VV")), SensorParameters.decode(line.ask_until_answered("PP"))
    except DecodeError as error:
        raise RobotError(f"{line.port.url}: the lidar's description makes no sense: {error}") from error


def choose_request(parameters: SensorParameters, baud: int | None) -> ScanRequest:
    """Choose the fullest scans that a line of this bit rate has room for; None is a line without one."""
    full = ScanRequest("MD", parameters.first, parameters.last)
    if baud is None or _fits(full, parameters, baud) <= 1:
        return full
    short = ScanRequest("MS", parameters.first, parameters.last)
    return ScanRequest("MS", short.first, short.last, interval=min(9, _fits(short, parameters, baud) - 1))


def stop_scans(line: ScipLine) -> None:
    """Switch the laser off, which ends the scans."""
    until = time.monotonic() + _LAST_ANSWER
    with suppress(PortLost):
        line.send("QT")
        while (left := until - time.monotonic()) > 0.0:
            if any(_is_answer(frame.lines, "QT") for frame in line.receive(left)):
                return


def _fits(request: ScanRequest, parameters: SensorParameters, baud: int) -> int:
    """Return the turns that the answer of one scan takes on the line."""
    size = request.values * request.width
    length = size + 2 * ceil(size / DATA_LINE) + _HEAD
    return ceil(length * BITS_PER_BYTE / baud / (parameters.scan_time * _FILL))


def _silence(line: ScipLine) -> bool:
    """Silence a sensor and bring it to SCIP 2.0; False where none answers at this bit rate."""
    line.send("")  # ends what an earlier client may have left unfinished
    silences = 0
    while silences < _SILENCES:
        reply = line.ask("QT")
        if reply is None:
            silences += 1
        elif reply.status == "00":
            return True
        else:
            silences += line.ask("TM2" if reply.status == "0E" else TO_SCIP2) is None
    return False


def _change_baud(line: ScipLine, baud: int) -> None:
    """Change the bit rate of sensor and port; a sensor on USB takes the command, and nothing changes."""
    if not line.port.has_baud or line.port.baud == baud:
        return
    before = line.port.baud
    reply = line.ask(set_baud(baud))
    if reply is None or reply.status not in ("00", "03"):
        return
    line.port.baud = baud
    if line.ask("QT") is None:
        line.port.baud = before


def _is_answer(lines: Lines, command: str) -> bool:
    reply = find_reply(lines)
    return reply is not None and reply.echo == command


def _old(lines: Lines) -> Reply | None:
    with suppress(DecodeError):
        return decode_old_reply(lines)
    return None
