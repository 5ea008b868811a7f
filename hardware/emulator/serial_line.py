"""The emulated serial line between a device and its port: its bit rate takes time, and its noise damages bytes."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from random import Random
from typing import Final, Protocol

from hardware.emulator.ports import Port
from hardware.serial_port import BITS_PER_BYTE
from hardware.wire.session import WireSession
from slam.pose import FloatArray

_CHUNK: Final = 16
"""Bytes that arrive together, as from the buffer of a UART."""
_LONGEST_QUEUE: Final = 16_384
"""Bytes that may wait to be sent; messages that do not fit are lost."""
_RETRY: Final = 0.02
"""Seconds until another attempt at a port that was full because its client does not read."""
_PATIENCE: Final = 1.0
"""Seconds of a full port after which new messages to it are lost."""


@dataclass(frozen=True, slots=True)
class LineNoise:
    """Probabilities, for each byte in either direction, that it is damaged, lost or doubled."""

    bit_errors: float = 0.0
    """Probability that one bit flips."""
    dropped: float = 0.0
    duplicated: float = 0.0

    def damage(self, data: bytes, rng: Random) -> bytes:
        """Return the bytes as they arrive."""
        if self == LineNoise():
            return data
        arrived = bytearray()
        for byte in data:
            if rng.random() < self.dropped:
                continue
            if rng.random() < self.bit_errors:
                byte ^= 1 << rng.randrange(8)
            arrived += bytes([byte]) * (2 if rng.random() < self.duplicated else 1)
        return bytes(arrived)


class SerialLine:
    """Bytes on their way from a device; a bit rate of ``None`` takes no time."""

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

    def take_arrived(self, now: float) -> Iterator[tuple[bytes, int | None]]:
        """Take the bytes that have arrived, each chunk with the bit rate at which it was sent."""
        while self._waiting and self._waiting[0][0] <= now:
            _, chunk, baud = self._waiting.popleft()
            self._size -= len(chunk)
            yield chunk, baud


class Device(Protocol):
    """A device on a line: it acts in ``step`` and ``receive`` only, and its time never goes back."""

    @property
    def baud(self) -> int:
        """Bit rate at which it talks."""
        ...

    @property
    def due(self) -> float:
        """Time of its next step."""
        ...

    @property
    def wake(self) -> float:
        """Time at which it must be served again, ``due`` or later."""
        ...

    def step(self) -> bytes:
        """Do what is due, and return the bytes it sends."""
        ...

    def receive(self, data: bytes, now: float) -> bytes:
        """Take bytes, and return the bytes it answers at once."""
        ...


class EmulatedLidar(Device, Protocol):
    """A lidar among the devices."""

    @property
    def laser(self) -> bool:
        """True while it measures."""
        ...

    @property
    def sweep(self) -> tuple[FloatArray, FloatArray]:
        """Bearings in the sensor's frame, and the last range measured at each, nan before the first; (N,) each."""
        ...

    def set_dead(self, dead: bool) -> None:
        """Fall silent, or come back to life."""
        ...

    def reboot(self, now: float) -> None:
        """Simulate a power failure: all state is reset."""
        ...


class ConnectedDevice:
    """Moves bytes between a device and a port.

    A ``limited`` line takes the time of its bit rate, as RS-232 does; otherwise it is USB, for which a bit rate means
    nothing. ``wire`` records what passes at the port.
    """

    def __init__(
        self, device: Device, port: Port, limited: bool, seed: int, noise: LineNoise, wire: WireSession
    ) -> None:
        self.device = device
        self.port = port
        self._noise = noise
        self._wire = wire
        self._limited = limited
        self._rng = Random(seed)
        self._line = SerialLine()
        self._stalled_until = -inf
        self._unread = b""
        """Bytes that the port did not accept: the rest of a message, which must not be cut."""
        self._unread_since = self._retry_at = -inf

    @property
    def wake(self) -> float:
        """Time of the next action."""
        due = self._retry_at if self._unread else self._line.due
        if due < inf:
            return max(min(due, self.device.wake), self._stalled_until)
        return self.device.wake

    def filenos(self, now: float) -> list[int]:
        """List the file descriptors to wait for; none while the line is stalled."""
        return self.port.filenos() if now >= self._stalled_until else []

    def stall(self, until: float) -> None:
        """Stall the line in both directions until then; the device's bytes wait."""
        self._stalled_until = until

    def unplug(self) -> None:
        """Pull the plug; bytes on their way are lost."""
        self._line, self._unread = SerialLine(), b""
        self.port.close()

    def take(self, now: float) -> None:
        """Give the device the bytes that its client has sent."""
        if now < self._stalled_until:
            return
        data = self.port.read()
        if data:
            self._wire.note(self.port.address, ">", data)
            baud = self._baud
            self._send(self.device.receive(self._through(data, baud), now), now, baud)

    def step(self) -> None:
        """Let the device do what is due."""
        now = self.device.due
        baud = self._baud
        self._send(self.device.step(), now, baud)

    def flush(self, now: float) -> None:
        """Give the client the bytes that have arrived at its end, as far as the port accepts them."""
        if now < self._stalled_until:
            return
        self._write(self._unread, now)
        for data, baud in self._line.take_arrived(now) if not self._unread else ():
            arriving = self._through(data, baud)
            self._wire.note(self.port.address, "<", arriving)
            self._write(arriving, now)
            if self._unread:
                break

    def _write(self, data: bytes, now: float) -> None:
        written = self.port.write(data) if data else 0
        if written or not self._unread:
            self._unread_since = now
        self._unread, self._retry_at = data[written:], now + _RETRY

    @property
    def _baud(self) -> int | None:
        """Bit rate of the device; an answer to a change of it is still sent at the old one."""
        return self.device.baud if self._limited else None

    def _send(self, data: bytes, now: float, baud: int | None) -> None:
        overdue = bool(self._unread) and now - self._unread_since > _PATIENCE
        if data and self.port.filenos() and not overdue:
            self._line.send(data, now, baud)

    def _through(self, data: bytes, baud: int | None) -> bytes:
        """Return the bytes as the other side reads them: damaged by noise, or random if its bit rate differs."""
        client = self.port.client_baud() if baud else None
        if client is not None and client != baud:
            return bytes(self._rng.randrange(0x80, 0x100) for _ in data[::2])
        return self._noise.damage(data, self._rng)
