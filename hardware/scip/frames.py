"""Framing: cuts the sensor's stream into answers, which end with an empty line, and the client's into commands."""

from typing import Final

_LONGEST: Final = 8192
"""Longest answer, bytes, with some margin; a full scan has 2137."""

Lines = tuple[bytes, ...]


class FrameDecoder:
    """Collects lines up to an empty one. Between two calls it holds less than one answer."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._searched = 0

    @property
    def pending(self) -> bool:
        """True while an answer has begun and is not yet complete."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[Lines]:
        """Take bytes, and return the lines of each answer that is now complete."""
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
        """Forget an incomplete answer after the line fell silent; it would spoil the next one."""
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
        """Take bytes, and return the commands that are now complete.

        Question marks replace bytes that are not ASCII.
        """
        self._buffer += data.replace(b"\r", b"\n")
        *lines, rest = self._buffer.split(b"\n")
        self._buffer = rest[-_LONGEST:]
        return [line.decode("ascii", "replace").replace("�", "?") for line in lines if line]
