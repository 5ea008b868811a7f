"""Framing: the sensor's stream is cut into answers, which an empty line ends, and the client's into commands."""

from typing import Final

_LONGEST: Final = 8192
"""Bytes: more than any answer has; a full scan has 2137."""

Lines = tuple[bytes, ...]


class FrameDecoder:
    """Collects lines until an empty one. It holds less than an answer between two calls."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._searched = 0

    @property
    def pending(self) -> bool:
        """True while an answer has begun that is not whole yet."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[Lines]:
        """Take bytes, and return the lines of each answer that is now whole."""
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
        """Forget an answer that had begun, as the line fell silent; it would spoil the next one."""
        self._buffer.clear()
        self._searched = 0

    def _bound(self) -> None:
        while self._buffer[:1] == b"\n" and len(self._buffer) > 1:
            del self._buffer[:1]
        if len(self._buffer) > _LONGEST:
            del self._buffer[: -_LONGEST // 2]
        self._searched = max(0, len(self._buffer) - 1)


class CommandDecoder:
    """Collects commands on the sensor's side; they end with LF, CR or both."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[str]:
        """Take bytes, and return the commands that are now whole; question marks replace what is no ASCII text."""
        self._buffer += data.replace(b"\r", b"\n")
        *lines, rest = self._buffer.split(b"\n")
        self._buffer = rest[-_LONGEST:]
        return [line.decode("ascii", "replace").replace("�", "?") for line in lines if line]
