"""A serial line with a SCIP sensor at its far end: commands out, answers in, with their times."""

import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from hardware import DecodeError
from hardware.scip.frames import FrameDecoder, Lines
from hardware.scip.reply import Reply, decode_old_reply, find_reply
from hardware.scip.status import is_ok, status_meaning
from hardware.serial_port import PortLost, SerialPort
from slam.errors import RobotError

ANSWER: Final = 0.5
"""Seconds to wait for an answer: the sensor sends it at the end of a turn, perhaps after a scan at 115200 baud."""
_LOOK: Final = 0.1
"""Seconds between two checks whether the program is ending."""
_TRIES: Final = 3


@dataclass(frozen=True, slots=True)
class RawAnswer:
    """Lines of an answer, and the times when its first and last bytes were read, seconds of ``time.monotonic``."""

    lines: Lines
    began: float
    ended: float


class ScipLine:
    """Sends commands and receives answers over a port; waiting ends with PortLost once ``leaving`` is set."""

    def __init__(self, port: SerialPort, leaving: threading.Event) -> None:
        self.port = port
        self._leaving = leaving
        self._decoder = FrameDecoder()
        self._began = self._heard_at = 0.0

    def send(self, command: str) -> None:
        """Write one command."""
        self.port.write(command.encode("ascii") + b"\n")

    def receive(self, timeout: float) -> list[RawAnswer]:
        """Return the answers that are complete now; none if nothing arrives within ``timeout`` seconds."""
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

    def ask(self, command: str, timeout: float = ANSWER) -> Reply | None:
        """Send a command, and return the answer with its echo; other answers are dropped. None if none arrives."""
        self.send(command)
        return self.wait_for(command, timeout)

    def wait_for(self, command: str, timeout: float) -> Reply | None:
        """Return the answer with this echo; None if none arrives."""
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
        """Ask several times; RobotError if the sensor does not answer, or refuses."""
        for _ in range(_TRIES):
            reply = self.ask(command)
            if reply is not None:
                if not is_ok(reply.status):
                    why = status_meaning(command, reply.status)
                    raise RobotError(f"{self.port.url}: the lidar refuses {command}: status {reply.status}, {why}")
                return reply
        raise RobotError(f"{self.port.url}: the lidar does not answer {command}")


def _old(lines: Lines) -> Reply | None:
    with suppress(DecodeError):
        return decode_old_reply(lines)
    return None
