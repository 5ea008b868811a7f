"""Pseudo-terminal that an emulated device listens on."""

import fcntl
import os
import pty
import struct
import sys
import termios
import tty
from contextlib import suppress
from pathlib import Path
from typing import Final

if sys.platform == "win32":
    raise ImportError("Windows has no pseudo-terminals")

_TCGETS2: Final = 0x802C542A
_TERMIOS2: Final = struct.Struct("4I20B2I")
"""Flags, line discipline and control characters, and the bit rates of input and output (asm-generic/termbits.h)."""
_AT_ONCE: Final = 4096
_SPEED: Final = 5
"""Index of the bit rate in the settings of termios."""


class PtyPort:
    """A pseudo-terminal, raw, with the symbolic link ``link`` to it where one is given."""

    def __init__(self, link: Path | None = None) -> None:
        self._link = link
        self._master = self._slave = -1
        self.open()

    @property
    def address(self) -> str:
        """Path of the link, or of the device."""
        return str(self._link) if self._link else os.ttyname(self._slave)

    def open(self) -> None:
        """Make a new terminal; it stays open when a client closes it."""
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        if self._link is not None:
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(os.ttyname(self._slave))

    def close(self) -> None:
        """Close the terminal; the client's reads and writes fail from now on."""
        if self._link is not None:
            self._link.unlink(missing_ok=True)
        for end in (self._master, self._slave):
            if end >= 0:
                os.close(end)
        self._master = self._slave = -1

    def filenos(self) -> list[int]:
        return [self._master] if self._master >= 0 else []

    def read(self) -> bytes:
        with suppress(BlockingIOError):
            if self._master >= 0:
                return os.read(self._master, _AT_ONCE)
        return b""

    def write(self, data: bytes) -> int:
        """Send bytes, and return how many found room; a terminal that no client reads fills up."""
        with suppress(BlockingIOError):
            return os.write(self._master, data) if self._master >= 0 else len(data)
        return 0

    def client_baud(self) -> int | None:
        """Read the bit rate from the terminal's settings; on Linux also a rate without a constant in termios."""
        if self._master < 0:
            return None
        if sys.platform != "linux":
            return int(termios.tcgetattr(self._master)[_SPEED])
        settings = bytearray(_TERMIOS2.size)
        fcntl.ioctl(self._master, _TCGETS2, settings)
        return int(_TERMIOS2.unpack(settings)[-1])
