"""A serial line with an ARCOS robot at its far end: commands out, packets in, with their times."""

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from hardware.arcos.commands import Command
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.serial_port import BITS_PER_BYTE, PortLost, SerialPort

ANSWER: Final = 0.4
"""Seconds within which a robot answers: one cycle and a long report at 9600 baud."""
_LOOK: Final = 0.1
"""Seconds between two checks whether the program is ending."""


@dataclass(frozen=True, slots=True)
class ReceivedPacket:
    """A packet's data, and the time when its first byte began to come, seconds of ``time.monotonic``."""

    data: bytes
    stamp: float


class ArcosLine:
    """Sends commands and receives packets over a port; waiting ends with PortLost once ``leaving`` is set."""

    def __init__(self, port: SerialPort, leaving: threading.Event) -> None:
        self.port = port
        self._leaving = leaving
        self._decoder = PacketDecoder()
        self._began = self._heard_at = 0.0
        self.report_when_found_open: ReceivedPacket | None = None
        """Last report of a robot that was found open, after it came to rest; its counts of travel are still valid."""

    @property
    def refused(self) -> Sequence[bytes]:
        """Data of the newest packets whose checksums were wrong."""
        return self._decoder.refused

    def send(self, command: Command) -> None:
        """Write one command."""
        self.port.write(encode_packet(command.encode()))

    def receive(self, timeout: float) -> list[ReceivedPacket]:
        """Return the packets that are complete now; none if nothing arrives within ``timeout`` seconds."""
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

    def wait_for(self, wanted: Callable[[bytes], bool], timeout: float = ANSWER) -> bytes | None:
        """Return the first wanted packet that arrives in time; others are dropped."""
        until = time.monotonic() + timeout
        while (left := until - time.monotonic()) > 0.0:
            if self._leaving.is_set():
                raise PortLost(f"{self.port.url}: given up")
            for arrival in self.receive(min(left, _LOOK)):
                if wanted(arrival.data):
                    return arrival.data
        return None

    def ask(self, command: Command, wanted: Callable[[bytes], bool], tries: int) -> bytes | None:
        """Send a command until a wanted packet arrives; None after ``tries`` without one."""
        for _ in range(tries):
            self.send(command)
            answer = self.wait_for(wanted)
            if answer is not None:
                return answer
        return None

    def drain(self) -> None:
        """Drop what still arrives, for a short while: a robot that was left open never pauses."""
        until = time.monotonic() + 0.2
        while self.port.read(0.05) and time.monotonic() < until:
            pass
        self._decoder = PacketDecoder()
