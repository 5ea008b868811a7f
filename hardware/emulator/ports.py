"""The ports that an emulated device listens on: a pseudo-terminal, or TCP on the loopback interface."""

import fcntl
import os
import pty
import socket
import struct
import tty
from contextlib import suppress
from pathlib import Path
from typing import Final

_TCGETS2: Final = 0x802C542A
_TERMIOS2: Final = struct.Struct("4I20B2I")
"""Flags, line discipline and control characters, and the bit rates of input and output (asm-generic/termbits.h)."""
_AT_ONCE: Final = 4096


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
        """Make a new terminal; this end stays open, so that the other end outlives every client."""
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
        """List the file descriptors to wait for; none while it is unplugged."""
        return [self._master] if self._master >= 0 else []

    def read(self) -> bytes:
        """Return the bytes that the client has sent."""
        with suppress(BlockingIOError):
            if self._master >= 0:
                return os.read(self._master, _AT_ONCE)
        return b""

    def write(self, data: bytes) -> int:
        """Send bytes, and return how many were accepted; a terminal that no client reads fills up."""
        with suppress(BlockingIOError):
            return os.write(self._master, data) if self._master >= 0 else len(data)
        return 0

    def client_baud(self) -> int | None:
        """Read the bit rate from the terminal's settings; any rate, also those without a constant in termios."""
        if self._master < 0:
            return None
        settings = bytearray(_TERMIOS2.size)
        fcntl.ioctl(self._master, _TCGETS2, settings)
        return int(_TERMIOS2.unpack(settings)[-1])


class TcpPort:
    """A TCP port on 127.0.0.1 for one client at a time; a newer client replaces an older one."""

    def __init__(self, number: int = 0) -> None:
        self._number = number
        self._listener: socket.socket | None = None
        self._client: socket.socket | None = None
        self.open()

    @property
    def address(self) -> str:
        """URL as pyserial opens it."""
        return f"socket://127.0.0.1:{self._number}"

    def open(self) -> None:
        """Listen; after the first time on the same port as before."""
        self._listener = socket.create_server(("127.0.0.1", self._number))
        self._listener.setblocking(False)
        self._number = self._listener.getsockname()[1]

    def close(self) -> None:
        """Close the connection."""
        for end in (self._client, self._listener):
            if end is not None:
                end.close()
        self._client = self._listener = None

    def filenos(self) -> list[int]:
        """List the file descriptors to wait for; none while it is unplugged."""
        return [end.fileno() for end in (self._listener, self._client) if end is not None]

    def read(self) -> bytes:
        """Return the bytes that the client has sent; a new client may come in meanwhile."""
        if self._listener is not None:
            with suppress(BlockingIOError):
                newcomer, _ = self._listener.accept()
                newcomer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                newcomer.setblocking(False)
                self._hang_up()
                self._client = newcomer
        try:
            data = self._client.recv(_AT_ONCE) if self._client else b""
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        return data

    def write(self, data: bytes) -> int:
        """Send bytes, and return how many were accepted; without a client they are dropped."""
        try:
            return self._client.send(data) if self._client is not None else len(data)
        except BlockingIOError:
            return 0
        except OSError:
            return len(data)

    def client_baud(self) -> None:
        """Return None: a TCP port has no bit rate."""

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = None


Port = PtyPort | TcpPort
"""One end of a line to a client; ``read`` and ``write`` never wait."""
