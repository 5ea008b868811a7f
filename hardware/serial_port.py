"""The one place that opens ports: a device, ``socket://host:port`` or ``loop://``."""

import errno
import os
import select
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Final

import serial

from hardware.port_errors import reason_of
from slam.errors import RobotError

BITS_PER_BYTE: Final = 10
"""8N1."""
_AT_ONCE: Final = 4096
"""Bytes that one read returns at most."""
_LONGEST_GAP: Final = 0.03
"""Seconds between two bytes of a message: a USB adapter keeps back what it has for 16 ms ..."""
_LONGEST_NETWORK_GAP: Final = 0.3
"""... and over a network a packet may be sent twice, or wait for its turn on a radio link."""


class PortLost(RobotError):
    """The port cannot be opened, or is gone: unplugged, hung up."""


class NoDevice(RobotError):
    """The port is open, but no device of the kind looked for answers there."""


class SerialPort:
    """A serial line, open from the start and for nobody else; PortLost when it cannot be, or is lost later."""

    def __init__(self, url: str, baud: int) -> None:
        self.url = url
        try:
            self._serial: Any = serial.serial_for_url(url, baudrate=baud, timeout=0.0, exclusive=True)
        except (OSError, ValueError, OverflowError) as error:  # SerialException is an OSError
            raise PortLost(f"{url}: {reason_of(url, error)}") from error
        self._fileno: int | None = None  # loop:// has none
        with suppress(OSError, AttributeError):
            self._fileno = int(self._serial.fileno())

    @property
    def has_baud(self) -> bool:
        """True where a bit rate means anything; it does not over TCP."""
        return "://" not in self.url

    @property
    def longest_gap(self) -> float:
        """Seconds of silence, on this kind of link, after which the rest of a message does not come any more."""
        return _LONGEST_GAP if self.has_baud else _LONGEST_NETWORK_GAP

    @property
    def baud(self) -> int:
        """Bits a second at this end."""
        return int(self._serial.baudrate)

    @baud.setter
    def baud(self, baud: int) -> None:
        try:
            self._serial.baudrate = baud
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.url}: cannot be set to {baud} baud: {error}") from error

    def read(self, timeout: float) -> bytes:
        """Return the bytes that have come, as soon as any have; none when none come in ``timeout`` seconds."""
        with self._lost_on_failure():
            if self._fileno is None:
                self._serial.timeout = timeout
                return bytes(self._serial.read(1) + self._serial.read(self._serial.in_waiting))
            ready, _, _ = select.select([self._fileno], [], [], timeout)
            if not ready:
                return b""
            data = os.read(self._fileno, _AT_ONCE)
            if not data:
                raise OSError(errno.EIO, "the device is gone")
            return data

    def write(self, data: bytes) -> None:
        """Send all bytes."""
        with self._lost_on_failure():
            self._serial.write(data)

    def close(self) -> None:
        """Give the port back; closing twice is allowed."""
        with suppress(OSError):  # it was unplugged: there is nothing to give back
            self._serial.close()

    @contextmanager
    def _lost_on_failure(self) -> Iterator[None]:
        try:
            yield
        except (OSError, TypeError, AttributeError) as error:  # pyserial's own, when the port was closed meanwhile
            raise PortLost(f"{self.url}: {reason_of(self.url, error)}") from error
