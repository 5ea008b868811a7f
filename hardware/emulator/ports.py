"""The ports that an emulated device listens on: a pseudo-terminal, or TCP on the loopback interface."""

import socket
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final, Protocol

from slam.errors import InputError

_CHUNK: Final = 4096


class Port(Protocol):
    """One end of a line to a client; ``read`` and ``write`` never wait."""

    @property
    def address(self) -> str:
        """Name under which a client opens the port."""

    def open(self) -> None:
        """Accept clients, also again after ``close``."""

    def close(self) -> None:
        """Disappear like an unplugged device; reads and writes of the client fail."""

    def filenos(self) -> list[int]:
        """List the file descriptors to wait for; none while it is unplugged."""

    def read(self) -> bytes:
        """Return the bytes that the client has sent."""

    def write(self, data: bytes) -> int:
        """Send bytes, and return how many were accepted."""

    def client_baud(self) -> int | None:
        """Return the bit rate that the client has set; None without one."""


def pseudo_terminal(link: Path | None = None) -> Port:
    """Open a pseudo-terminal, and make the symbolic link ``link`` to it, if given; InputError on Windows."""
    if sys.platform == "win32":
        raise InputError("Windows has no pseudo-terminals; give --tcp, and open the addresses that are printed")
    from hardware.emulator.pty_port import PtyPort

    return PtyPort(link)


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
        """Listen, always on the same port, which the system chooses the first time if its number was 0."""
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
            data = self._client.recv(_CHUNK) if self._client else b""
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
