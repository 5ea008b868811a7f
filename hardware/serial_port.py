"""The one place that opens ports: a device, ``socket://host:port``, ``loop://``, or ``wire:FILE``, a recording."""

import errno
import os
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Final

import serial

from hardware.port_errors import reason_of
from hardware.wire.session import WireSession
from hardware.wire.tape import SCHEME
from slam.errors import RobotError

BITS_PER_BYTE: Final = 10
"""Parity and stop bits: 8N1."""
_AT_ONCE: Final = 4096
"""Bytes that one read returns at most."""
_LONGEST_GAP: Final = 0.03
"""Longest pause, seconds, between two bytes of a message: a USB adapter holds bytes back for up to 16 ms."""
_LONGEST_NETWORK_GAP: Final = 0.3
"""Longest pause over a network, seconds, where a packet may be sent twice, or wait on a radio link."""


class PortLost(RobotError):
    """The port cannot be opened, or was lost: unplugged, hung up."""


class NoDevice(RobotError):
    """The port is open, but no device of the expected kind answers there."""


class SerialPort:
    """A serial line, opened by the constructor for this process alone; PortLost if that fails, or if it is lost later.

    ``wire`` is shared by the ports of one session; without it nothing is recorded.
    """

    def __init__(self, url: str, baud: int, wire: WireSession | None = None) -> None:
        self.url = url
        self._wire = wire or WireSession()
        try:
            self._serial: Any = self._open(baud)
        except (OSError, ValueError, OverflowError) as error:  # SerialException is an OSError
            raise PortLost(f"{url}: {reason_of(url, error)}") from error
        self._wire.note(url, "=", str(baud))
        self._fileno: int | None = None  # loop:// has none, nor have the ports of Windows
        with suppress(OSError, AttributeError):
            self._fileno = int(self._serial.fileno())

    @property
    def has_baud(self) -> bool:
        """True if a bit rate means anything; it does not over TCP."""
        return bool(self._serial.has_baud) if self.url.startswith(SCHEME) else "://" not in self.url

    @property
    def longest_gap(self) -> float:
        """Seconds of silence, on this kind of link, after which the rest of a message will not come."""
        return _LONGEST_GAP if self.has_baud else _LONGEST_NETWORK_GAP

    @property
    def baud(self) -> int:
        """Bit rate at this end."""
        return int(self._serial.baudrate)

    @baud.setter
    def baud(self, baud: int) -> None:
        if baud == self.baud:
            return
        try:
            self._serial.baudrate = baud
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.url}: cannot be set to {baud} baud: {error}") from error
        self._wire.note(self.url, "=", str(baud))

    def read(self, timeout: float) -> bytes:
        """Return the bytes that have arrived, as soon as there are any; none after ``timeout`` seconds."""
        with self._lost_on_failure():
            data = self._read(timeout)
        if data:
            self._wire.note(self.url, "<", data)
        return data

    def write(self, data: bytes) -> None:
        """Send all bytes."""
        self._wire.note(self.url, ">", data)
        with self._lost_on_failure():
            self._serial.write(data)

    def close(self) -> None:
        """Close the port; closing twice is allowed."""
        with suppress(OSError):  # it was unplugged: there is nothing to close
            self._serial.close()
        self._wire.note(self.url, "-", "")

    def _open(self, baud: int) -> Any:
        if self.url.startswith(SCHEME):
            return self._wire.tape(self.url)
        return serial.serial_for_url(self.url, baudrate=baud, timeout=0.0, exclusive=True)

    def _read(self, timeout: float) -> bytes:
        if self._fileno is None:
            self._serial.timeout = timeout
            return bytes(self._serial.read(1) + self._serial.read(self._serial.in_waiting))
        ready, _, _ = select.select([self._fileno], [], [], timeout)
        if not ready:
            return b""
        if sys.platform == "win32":  # os.read cannot read from a socket
            return bytes(self._serial.read(_AT_ONCE))
        data = os.read(self._fileno, _AT_ONCE)
        if not data:
            raise OSError(errno.EIO, "the device is gone")
        return data

    @contextmanager
    def _lost_on_failure(self) -> Iterator[None]:
        try:
            yield
        except (OSError, TypeError, AttributeError) as error:  # pyserial's own, if the port was closed meanwhile
            reason = reason_of(self.url, error)
            self._wire.note(self.url, "-", reason)
            raise PortLost(f"{self.url}: {reason}") from error
