"""An emulated device at its port, with the wire between them."""

from __future__ import annotations

from math import inf
from random import Random

from hardware.emulator.device import Device
from hardware.emulator.ports import Port
from hardware.emulator.wire import Line, Noise, misread


class Station:
    """Moves bytes between a device and a port. ``limited`` lines take the time of their bit rate, as RS-232 does; the
    others are USB's, for which a bit rate means nothing."""

    def __init__(self, device: Device, port: Port, limited: bool, seed: int, noise: Noise) -> None:
        self.device = device
        self.port = port
        self.noise = noise
        self._limited = limited
        self._rng = Random(seed)
        self._out = Line()
        self._stalled_until = -inf

    @property
    def wake(self) -> float:
        """When there is next something to do."""
        if self._out.due < inf:
            return max(min(self._out.due, self.device.wake), self._stalled_until)
        return self.device.wake

    def filenos(self, now: float) -> list[int]:
        """What to wait for; nothing while the line is stalled."""
        return self.port.filenos() if now >= self._stalled_until else []

    def stall(self, until: float) -> None:
        """Nothing comes through in either direction until then; what the device says waits."""
        self._stalled_until = until

    def unplug(self) -> None:
        """Pull the plug; what is on its way is lost."""
        self._out.clear()
        self.port.close()

    def take(self, now: float) -> None:
        """Give the device what its client has sent."""
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
        """Give the client what has arrived at its end."""
        if now >= self._stalled_until:
            for data, baud in self._out.arrived(now):
                self.port.write(self._through(data, baud))

    @property
    def _baud(self) -> int | None:
        """At which the device talks; an answer to a change of it is still sent at the old one."""
        return self.device.baud if self._limited else None

    def _send(self, data: bytes, now: float, baud: int | None) -> None:
        if data and self.port.filenos():
            self._out.send(data, now, baud)

    def _through(self, data: bytes, baud: int | None) -> bytes:
        """What the other side reads of bytes that were sent at this bit rate."""
        client = self.port.client_baud() if baud else None
        if client is not None and client != baud:
            return misread(data, self._rng)
        return self.noise.damage(data, self._rng)
