"""The one place that opens ports: a device, ``socket://host:port`` or ``loop://``."""

from __future__ import annotations

import errno
import os
import select
from contextlib import suppress
from typing import Any, Final

import serial

from slam.errors import RobotError

_AT_ONCE: Final = 4096
_CURES: Final = {
    errno.ENOENT: "there is no such port; plug the device in, and see hopslam doctor for the ports there are",
    errno.EACCES: "you may not use this port; run: sudo usermod -aG dialout $USER, then log out and in again",
    errno.EBUSY: "another program is using it; close that one first",
    errno.EIO: "the device is gone; was it unplugged?",
    errno.ECONNREFUSED: "nobody listens there; start the emulator or the serial server first",
}


class PortLost(RobotError):
    """The port cannot be opened, or is gone: unplugged, hung up."""


class SerialPort:
    """A serial line, open from the start and for nobody else; PortLost when it cannot be, or is lost later."""

    def __init__(self, url: str, baud: int) -> None:
        self.url = url
        try:
            self._serial: Any = serial.serial_for_url(url, baudrate=baud, timeout=0.0, exclusive=True)
        except (OSError, ValueError) as error:  # SerialException is an OSError
            raise PortLost(f"{url}: {_reason(error)}") from error
        self._fileno = self._find_fileno()

    @property
    def has_baud(self) -> bool:
        """Whether a bit rate means anything here; it does not over TCP."""
        return "://" not in self.url

    @property
    def baud(self) -> int:
        """Bits a second, of this end."""
        return int(self._serial.baudrate)

    @baud.setter
    def baud(self, baud: int) -> None:
        try:
            self._serial.baudrate = baud
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.url}: cannot be set to {baud} baud: {error}") from error

    def read(self, timeout: float) -> bytes:
        """What has come, as soon as anything has; nothing when nothing does in ``timeout`` seconds."""
        try:
            return self._read(timeout)
        except (OSError, TypeError, AttributeError) as error:  # pyserial's own, when the port was closed meanwhile
            raise PortLost(f"{self.url}: {_reason(error)}") from error

    def write(self, data: bytes) -> None:
        """Send all of it."""
        try:
            self._serial.write(data)
        except (OSError, TypeError, AttributeError) as error:
            raise PortLost(f"{self.url}: {_reason(error)}") from error

    def close(self) -> None:
        """Give the port back; closing twice is allowed."""
        with suppress(OSError):  # it was unplugged: there is nothing to give back
            self._serial.close()

    def _read(self, timeout: float) -> bytes:
        if self._fileno is None:  # loop://
            self._serial.timeout = timeout
            return bytes(self._serial.read(1) + self._serial.read(self._serial.in_waiting))
        ready, _, _ = select.select([self._fileno], [], [], timeout)
        if not ready:
            return b""
        data = os.read(self._fileno, _AT_ONCE)
        if not data:
            raise OSError(errno.EIO, "the device is gone")
        return data

    def _find_fileno(self) -> int | None:
        try:
            return int(self._serial.fileno())
        except (OSError, AttributeError):
            return None


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number is None and "Could not exclusively lock" in str(error):
        number = errno.EBUSY
    if number == errno.EAGAIN:
        number = errno.EBUSY
    return _CURES.get(number or 0, str(error))
