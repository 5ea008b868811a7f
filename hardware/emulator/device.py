"""What the wire knows of an emulated device."""

from __future__ import annotations

from typing import Protocol


class Device(Protocol):
    """A machine of bytes and time: it does nothing but in these calls, and time never goes back."""

    @property
    def baud(self) -> int:
        """The bit rate that it listens and talks at; it may change its mind."""
        ...

    @property
    def due(self) -> float:
        """When it next does something by itself, seconds."""
        ...

    @property
    def wake(self) -> float:
        """When it may next have something to say; no sooner than ``due``, and nobody needs to look before."""
        ...

    def step(self) -> bytes:
        """Do what is due; what it says."""
        ...

    def receive(self, data: bytes, now: float) -> bytes:
        """Take what came in; what it says at once."""
        ...
