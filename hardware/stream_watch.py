"""Hang-ups of the standard streams: a terminal is closed, or the reader of the output ends."""

import os
import select
import socket
import stat
import sys
from typing import Final

_STREAMS: Final = {0: "standard input", 1: "standard output", 2: "standard error"}


class StreamWatch:
    """Waits for bytes at a socket and for hang-ups of the standard streams; Windows does not report hang-ups.

    It watches terminals, and pipes and sockets that other programs read. Standard input from a file or a pipe is not
    watched.
    """

    def __init__(self, wake: socket.socket) -> None:
        self._wake = wake
        if sys.platform != "win32":
            self._poll = select.poll()
            for stream in filter(_is_watched, _STREAMS):
                self._poll.register(stream, 0)  # errors and hang-ups, which poll always reports
            for stream, event in self._poll.poll(0):
                if event & select.POLLNVAL:
                    self._poll.unregister(stream)  # macOS does not watch terminals
            self._poll.register(wake, select.POLLIN)

    def wait(self, timeout: float) -> tuple[bool, list[str]]:
        """Wait at most ``timeout`` seconds; return whether bytes arrived, and the names of the lost streams."""
        if sys.platform == "win32":
            return bool(select.select([self._wake], [], [], timeout)[0]), []
        ready = [fd for fd, _ in self._poll.poll(1e3 * timeout)]
        lost = [fd for fd in ready if fd in _STREAMS]
        for stream in lost:
            self._poll.unregister(stream)
        return len(lost) < len(ready), [_STREAMS[fd] for fd in lost]


def _is_watched(stream: int) -> bool:
    if os.isatty(stream):
        return True
    try:
        mode = os.fstat(stream).st_mode
    except OSError:  # it was closed before the program began
        return False
    return stream > 0 and (stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode))
