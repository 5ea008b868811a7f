"""Cutting the sensor's stream into answers, which an empty line ends."""

from __future__ import annotations

from typing import Final

_LONGEST: Final = 8192
"""Bytes: more than any answer has; a full scan has 2137."""

Lines = tuple[bytes, ...]


class FrameDecoder:
    """Collects lines until an empty one. It holds less than an answer between two calls."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._searched = 0
        self.overlong = 0
        """How often bytes were dropped because no empty line came."""

    @property
    def pending(self) -> bool:
        """Whether an answer has begun that is not whole yet."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[Lines]:
        """The lines of each answer that is now whole."""
        self._buffer += data
        frames = []
        while (end := self._buffer.find(b"\n\n", self._searched)) >= 0:
            lines = bytes(self._buffer[:end]).strip(b"\n")
            if lines:
                frames.append(tuple(lines.split(b"\n")))
            del self._buffer[: end + 2]
            self._searched = 0
        self._bound()
        return frames

    def flush(self) -> None:
        """The line fell silent: forget what had begun, which would spoil the next answer."""
        self._buffer.clear()
        self._searched = 0

    def _bound(self) -> None:
        while self._buffer[:1] == b"\n" and len(self._buffer) > 1:
            del self._buffer[:1]
        if len(self._buffer) > _LONGEST:
            self.overlong += 1
            del self._buffer[: -_LONGEST // 2]
        self._searched = max(0, len(self._buffer) - 1)


class CommandDecoder:
    """The other direction, for a sensor: commands end with LF, CR or both."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[str]:
        """The commands that are now whole; what is no ASCII text is replaced by question marks."""
        self._buffer += data.replace(b"\r", b"\n")
        *lines, rest = self._buffer.split(b"\n")
        self._buffer = rest[-_LONGEST:]
        return [line.decode("ascii", "replace").replace("�", "?") for line in lines if line]
