"""An emulated device at its port, with the serial line between them."""

from math import inf
from random import Random

from hardware.emulator.p3dx import EmulatedP3dx
from hardware.emulator.ports import Port
from hardware.emulator.serial_line import LineNoise, SerialLine, misread
from hardware.emulator.urg04lx import EmulatedUrg04lx

Device = EmulatedP3dx | EmulatedUrg04lx
"""A machine of bytes and time: it acts in ``step`` and ``receive`` only, and time never goes back."""


class ConnectedDevice:
    """Moves bytes between a device and a port.

    A ``limited`` line takes the time of its bit rate, as RS-232 does; one that is not is USB, for which a bit rate
    means nothing.
    """

    def __init__(self, device: Device, port: Port, limited: bool, seed: int, noise: LineNoise) -> None:
        self.device = device
        self.port = port
        self._noise = noise
        self._limited = limited
        self._rng = Random(seed)
        self._line = SerialLine()
        self._stalled_until = -inf

    @property
    def wake(self) -> float:
        """Time at which there is next something to do."""
        if self._line.due < inf:
            return max(min(self._line.due, self.device.wake), self._stalled_until)
        return self.device.wake

    def filenos(self, now: float) -> list[int]:
        """List the file descriptors to wait for; none while the line is stalled."""
        return self.port.filenos() if now >= self._stalled_until else []

    def stall(self, until: float) -> None:
        """Let nothing through in either direction until then; the device's bytes wait."""
        self._stalled_until = until

    def unplug(self) -> None:
        """Pull the plug; bytes on their way are lost."""
        self._line.clear()
        self.port.close()

    def take(self, now: float) -> None:
        """Give the device the bytes that its client has sent."""
        if now < self._stalled_until:
            return
        data = self.port.read()
        if data:
            baud = self._baud
            self._send(self.device.receive(self._through(data, baud), now), now, baud)

    def step(self) -> None:
        """Let the device do what is due."""
        now = self.device.due
        baud = self._baud
        self._send(self.device.step(), now, baud)

    def flush(self, now: float) -> None:
        """Give the client the bytes that have arrived at its end."""
        if now >= self._stalled_until:
            for data, baud in self._line.take_arrived(now):
                self.port.write(self._through(data, baud))

    @property
    def _baud(self) -> int | None:
        """Bit rate at which the device talks; an answer to a change of it is still sent at the old one."""
        return self.device.baud if self._limited else None

    def _send(self, data: bytes, now: float, baud: int | None) -> None:
        if data and self.port.filenos():
            self._line.send(data, now, baud)

    def _through(self, data: bytes, baud: int | None) -> bytes:
        """Return the bytes that the other side reads of those sent at this bit rate."""
        client = self.port.client_baud() if baud else None
        if client is not None and client != baud:
            return misread(data, self._rng)
        return self._noise.damage(data, self._rng)
