"""A wire recording as a device: it repeats what the recorded device sent, with the interface of a pyserial port."""

import threading
import time
from collections.abc import Iterator, Sequence
from math import inf
from pathlib import Path
from typing import Final

from hardware.arcos.commands import CommandId
from hardware.arcos.packet import HEADER
from hardware.wire.events import WireEvent, read_wire
from slam.errors import InputError

SCHEME: Final = "wire:"
_LONGEST_HOLD: Final = 3.0
"""Seconds to wait for a recorded question that the driver does not ask; then the tape continues."""
_FARTHEST_AHEAD: Final = 10.0
"""Seconds of the recording within which a question of the driver is searched."""
_HANDSHAKE: Final = (0, 1, 2)
"""SYNC0, SYNC1 with OPEN, SYNC2."""
_OPENS: Final[dict[int, bool]] = {CommandId.OPEN: True, CommandId.CLOSE: False}
_WITHOUT_ARGUMENT: Final = 6
"""Length of a packet without data, bytes."""


class WireTape:
    """The conversation at one port of a recording. It plays once, and continues where it was when it is opened again.

    It plays in real time. At a question it waits for the driver to ask the same one, and continues from there, so that
    a driver that asks earlier, later or in another order is answered too. At the first question it waits without
    limit, at others for a limited time. Questions are the commands of SCIP, and those of ARCOS that open a robot, and
    CONFIG; other commands in the recording need no counterpart.
    """

    def __init__(self, url: str) -> None:
        path, _, port = url.removeprefix(SCHEME).partition("#")
        self._events = _conversation(Path(path), port)
        self._robot_open = tuple(_openness(self._events))
        self._questions = [
            index
            for index, (event, is_open) in enumerate(zip(self._events, self._robot_open, strict=False))
            if event.kind == ">" and _is_question(event.data, is_open)
        ]
        self._at = 0
        self._asked = False
        self._shift: float | None = None
        """Seconds from the clock of the file to the host's; None before the tape runs."""
        self._arrived = bytearray()
        self._news = threading.Condition()
        self.timeout = 0.0
        self.baudrate = 0
        self.has_baud = "://" not in self._events[0].port

    @property
    def in_waiting(self) -> int:
        """Number of bytes that have come and are not read yet."""
        return len(self._arrived)

    def read(self, size: int) -> bytes:
        """Return up to ``size`` bytes, as soon as any have come, or none after ``timeout`` seconds.

        OSError at the end of the recording, and where the recorded port was lost.
        """
        until = time.monotonic() + self.timeout
        with self._news:
            while not self._arrived:
                next_due = self._advance(time.monotonic())
                left = min(until, next_due) - time.monotonic()
                if self._arrived or time.monotonic() >= until:
                    break
                self._news.wait(max(left, 0.0))
            data = bytes(self._arrived[:size])
            del self._arrived[:size]
            return data

    def write(self, data: bytes) -> int:
        """Take what the driver sends; the tape continues at the same question in the recording."""
        with self._news:
            index = self._find(data)
            if index is not None:
                self._asked = True
                self._at, self._shift = index + 1, time.monotonic() - self._events[index].stamp
                self._arrived.clear()
            self._news.notify_all()
        return len(data)

    def close(self) -> None:
        """Let the tape wait until it is opened again."""
        with self._news:
            self._arrived.clear()
            self._shift = None

    def _advance(self, now: float) -> float:
        """Play all that is due, and return the time of the next event."""
        if self._shift is None:
            self._shift = now - self._events[min(self._at, len(self._events) - 1)].stamp
        while self._at < len(self._events):
            event = self._events[self._at]
            due = event.stamp + self._shift
            if self._at in self._questions:
                due += _LONGEST_HOLD if self._asked else inf
            if now < due or (event.kind == "-" and self._arrived):
                return due
            self._shift = max(self._shift, due - event.stamp)
            self._at += 1
            self._arrived += event.data if event.kind == "<" else b""
            if event.kind == "-" and event.text:
                raise OSError(event.text)
        if not self._arrived:
            raise OSError("the recording ends here")
        return now

    def _find(self, data: bytes) -> int | None:
        """Return the index of this question in the recording: the next one within _FARTHEST_AHEAD, else the last one.

        None if the question is not in the recording.
        """
        if not _is_question(data, self._robot_open[self._at]):
            return None
        places = [index for index in self._questions if self._events[index].data == data]
        now = self._events[min(self._at, len(self._events) - 1)].stamp
        ahead = [k for k in places if k >= self._at and self._events[k].stamp - now < _FARTHEST_AHEAD]
        return next(iter(ahead), max((k for k in places if k < self._at), default=None))


def _conversation(path: Path, port: str) -> list[WireEvent]:
    """Return the events of one port; InputError lists the ports if there are several and none is chosen."""
    events = list(read_wire(path))
    ports = list(dict.fromkeys(event.port for event in events if event.kind in "><"))
    if not port and len(ports) == 1:
        port = ports[0]
    if port not in ports:
        known = " or ".join(f"{SCHEME}{path}#{name}" for name in ports) or "a recording with bytes in it"
        raise InputError(f"{SCHEME}{path}{'#' * bool(port)}{port}: choose {known}")
    return [event for event in events if event.port == port]


def _is_question(data: bytes, robot_open: bool) -> bool:
    """Return True for bytes that get an answer. While a robot is open, SYNC0 and SYNC1 are PULSE and OPEN."""
    if not data.startswith(HEADER):
        return data.isascii() and data.endswith(b"\n") and len(data) > 1
    return data[3] == CommandId.CONFIG or (not robot_open and data[3] in _HANDSHAKE)


def _openness(events: Sequence[WireEvent]) -> Iterator[bool]:
    """Yield for each event whether an ARCOS robot is open before it, and finally whether it is open at the end.

    OPEN and CLOSE have an argument, SYNC1 and SYNC2 have none.
    """
    robot_open = False
    for event in events:
        yield robot_open
        if event.kind == ">" and event.data.startswith(HEADER) and len(event.data) > _WITHOUT_ARGUMENT:
            robot_open = _OPENS.get(event.data[3], robot_open)
    yield robot_open
