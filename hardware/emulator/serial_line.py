"""The emulated serial line between a device and its port: its bit rate takes time, and its noise damages bytes."""

from collections import deque
from dataclasses import dataclass
from math import inf
from random import Random
from typing import Final

from hardware.serial_port import BITS_PER_BYTE

_CHUNK: Final = 16
"""Bytes that arrive together, as from the buffer of a UART."""
_LONGEST_QUEUE: Final = 16_384
"""Bytes that wait to be sent; more are lost."""


@dataclass(frozen=True, slots=True)
class LineNoise:
    """Probabilities, for each byte in either direction, that it is damaged, lost or doubled."""

    bit_errors: float = 0.0
    """Probability that one bit turns over."""
    dropped: float = 0.0
    duplicated: float = 0.0

    def damage(self, data: bytes, rng: Random) -> bytes:
        """Return the bytes as they arrive."""
        if self == _QUIET:
            return data
        arrived = bytearray()
        for byte in data:
            if rng.random() < self.dropped:
                continue
            if rng.random() < self.bit_errors:
                byte ^= 1 << rng.randrange(8)
            arrived += bytes([byte]) * (2 if rng.random() < self.duplicated else 1)
        return bytes(arrived)


_QUIET: Final = LineNoise()


class SerialLine:
    """Bytes on their way from a device; ``None`` bits a second take no time."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[float, bytes, int | None]] = deque()
        self._size = 0
        self._free_at = -inf

    def send(self, data: bytes, now: float, baud: int | None) -> None:
        """Put bytes on the line, behind those that still wait."""
        if self._size + len(data) > _LONGEST_QUEUE:
            return
        at = max(now, self._free_at)
        for start in range(0, len(data), _CHUNK if baud else max(len(data), 1)):
            chunk = data[start : start + _CHUNK] if baud else data
            at += len(chunk) * BITS_PER_BYTE / baud if baud else 0.0
            self._waiting.append((at, chunk, baud))
        self._size += len(data)
        self._free_at = at

    @property
    def due(self) -> float:
        """Time at which the next bytes arrive; inf without any."""
        return self._waiting[0][0] if self._waiting else inf

    def take_arrived(self, now: float) -> list[tuple[bytes, int | None]]:
        """Take the bytes that have come through, each chunk with the bit rate it was sent at."""
        chunks = []
        while self._waiting and self._waiting[0][0] <= now:
            _, chunk, baud = self._waiting.popleft()
            self._size -= len(chunk)
            chunks.append((chunk, baud))
        return chunks

    def clear(self) -> None:
        """Forget the bytes on their way."""
        self._waiting.clear()
        self._size = 0
        self._free_at = -inf


def misread(data: bytes, rng: Random) -> bytes:
    """Return random bytes for those read at another bit rate than they were sent with."""
    return bytes(rng.randrange(0x80, 0x100) for _ in data[::2])
