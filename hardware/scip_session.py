"""The dialogue with a SCIP sensor: finds it on the line whatever state it is in, asks, stops scans."""

import logging
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from hardware import DecodeError
from hardware.scip.commands import TO_SCIP2, set_baud
from hardware.scip.frames import FrameDecoder, Lines
from hardware.scip.information import SensorParameters, VersionInfo
from hardware.scip.reply import Reply, decode_old_reply, decode_reply, find_reply
from hardware.scip.status import is_ok, status_meaning
from hardware.serial_port import NoDevice, PortLost, SerialPort
from slam.errors import RobotError

_LOG: Final = logging.getLogger("hopslam.urg04lx")
_BAUD_SEARCH: Final = (19200, 115200, 57600, 38400, 500000, 750000, 250000)
_ANSWER: Final = 0.5
"""Seconds: an answer comes at the end of a turn, and may stand behind a scan at 115200 baud."""
_LOOK: Final = 0.1
"""Seconds between two looks whether the program is leaving."""
_LAST_ANSWER: Final = 0.3
"""Seconds to wait for the answer to the last QT."""
_TRIES: Final = 3
_ROUNDS: Final = 5
"""Questions in all by which a sensor is brought to SCIP 2.0."""
_IN_TIME_MODE: Final = ("0E", "10")
"""Status of a command that is refused between TM0 and TM2: of a URG-04LX, and of later sensors."""
_UPDATE: Final = (
    "speaks SCIP 1 only: update the firmware to 3.0 or later with the tool of Hokuyo's download page (Windows, over "
    "USB), or have the dealer do it"
)
_SILENCES: Final = 2
"""Questions without an answer after which a bit rate is given up."""


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
    """Ask the sensor for its identity, which informs people only, and for its abilities, without which nothing goes."""
    version = _version(line)
    try:
        return version, SensorParameters.decode(line.ask_until_answered("PP"))
    except DecodeError as error:
        raise RobotError(f"{line.port.url}: the lidar's description makes no sense: {error}") from error


def stop_scans(line: ScipLine) -> None:
    """Switch the laser off, which ends the scans."""
    until = time.monotonic() + _LAST_ANSWER
    with suppress(PortLost):
        line.send("QT")
        while (left := until - time.monotonic()) > 0.0:
            if any(_is_answer(frame.lines, "QT") for frame in line.receive(left)):
                return


def _silence(line: ScipLine) -> bool:
    """Silence a sensor and bring it to SCIP 2.0; False where none answers at this bit rate.

    RobotError for a sensor that answers, but cannot.
    """
    line.send("")  # ends what an earlier client may have left unfinished
    reply, silences = None, 0
    for _ in range(_ROUNDS):
        answer = line.ask("QT")
        if answer is None:
            silences += 1
            if silences == _SILENCES:
                break
            continue
        reply = answer
        if reply.status == "00":
            return True
        line.ask("TM2" if reply.status in _IN_TIME_MODE else TO_SCIP2)
    if reply is None:
        return False
    if len(reply.status) == 1:
        raise RobotError(f"{line.port.url}: {_too_old(line)}")
    why = status_meaning("QT", reply.status)
    raise RobotError(f"{line.port.url}: the lidar does not stop: status {reply.status} to QT, {why}")


def _too_old(line: ScipLine) -> str:
    """Return what to do with a sensor that knows SCIP 1 only."""
    reply = line.ask("V")
    with suppress(DecodeError):
        if reply is not None:
            firmware = VersionInfo.decode(reply).firmware
            return f"the lidar's firmware, {firmware}, {_UPDATE}"
    return f"the lidar's firmware {_UPDATE}"


def _version(line: ScipLine) -> VersionInfo:
    """Ask for the sensor's identity; what is damaged or missing of it is unknown, with a warning."""
    lines: Lines = ()
    for _ in range(_TRIES):
        line.send("VV")
        until = time.monotonic() + _ANSWER
        while not lines and (left := until - time.monotonic()) > 0.0:
            lines = next((frame.lines for frame in line.receive(left) if frame.lines[0].endswith(b"VV")), ())
        if lines:
            break
    with suppress(DecodeError):
        return VersionInfo.decode(decode_reply(lines))
    _LOG.warning(
        "%s: the lidar does not say who it is, its answer to VV is damaged, or a refusal",
        line.port.url,
    )
    return VersionInfo.decode_leniently(lines)


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
