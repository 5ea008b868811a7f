"""Records the traffic on the ports in a file, without delaying a driver when the disk is slow."""

import logging
import os
import threading
import time
from collections import deque
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from hardware.wire.events import HEADER, Kind, WireEvent
from slam.closing import Closing
from slam.errors import InputError

_APPEND: Final = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
"""Flags of the file; without O_BINARY, which only Windows has, it would change the line ends."""
_LOG: Final = logging.getLogger("hopslam.wire")
_PERIOD: Final = 0.1
"""Seconds between two writes: the most that a killed program can lose."""
_MAX_WAITING: Final = 20_000
"""Events that may wait for a slow disk, some minutes of both devices; more are dropped, with a warning."""


class WireRecorder(Closing):
    """Appends events to a file on its own thread; InputError if the file cannot be opened and written.

    If the disk fails later, the recording ends with a warning, and the run continues.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        try:
            self._file = os.open(path, _APPEND, 0o644)
            self._write(f"{HEADER}: seconds of a monotonic clock; {time.monotonic():.6f} was {now}\n")
        except OSError as error:
            raise InputError(
                f"{path}: cannot be written: {error.strerror}; choose another --record-wire FILE"
            ) from error
        self._waiting: deque[WireEvent] = deque()
        self._dropped = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="wire recorder", daemon=True)
        self._thread.start()

    def add(self, port: str, kind: Kind, content: bytes | str) -> None:
        """Record an event that happens now; callable from any thread, without waiting."""
        if self._over.is_set():
            return
        if len(self._waiting) >= _MAX_WAITING:
            self._dropped += 1
            return
        data, text = (content, "") if isinstance(content, bytes) else (b"", content)
        self._waiting.append(WireEvent(time.monotonic(), port, kind, data, text))

    def close(self) -> None:
        """Write what still waits; closing twice is allowed."""
        if not self._over.is_set():
            self._over.set()
            self._thread.join()
            os.close(self._file)

    def _serve(self) -> None:
        while not self._over.wait(_PERIOD):
            if not self._flush():
                self._over.wait()
                return
        self._flush()

    def _flush(self) -> bool:
        """Write the events that wait; return False once the disk has failed."""
        events = [self._waiting.popleft() for _ in range(len(self._waiting))]
        dropped, self._dropped = self._dropped, 0
        if dropped:
            events.append(WireEvent(time.monotonic(), str(self._path), "-", text=f"the disk is slow: {dropped} lost"))
        try:
            self._write("".join(event.line() for event in events))
        except OSError as error:
            _LOG.warning("%s: %s; the wire is not recorded any more", self._path, error.strerror)
            return False
        return True

    def _write(self, text: str) -> None:
        data = memoryview(text.encode("ascii", "backslashreplace"))
        while data:
            data = data[os.write(self._file, data) :]
