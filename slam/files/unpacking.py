"""Unpacking of data within limits: gzip, bz2, lz4 and zstd, chunks and whole files."""

from __future__ import annotations

import bz2
import gzip
import io
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import IO, Any, Final

import lz4.frame
import zstandard

from slam.errors import LogError
from slam.limits import CHUNK, UNPACKED, UNPACKED_AT_ONCE, UNPACKED_PER_BYTE

_BLOCK: Final = 1 << 16
_OPENERS: Final[dict[str, Callable[[Any], Any]]] = {
    "bz2": bz2.BZ2File,
    "gzip": lambda file: gzip.GzipFile(fileobj=file),
    "lz4": lz4.frame.LZ4FrameFile,
    "zstd": lambda file: zstandard.ZstdDecompressor(max_window_size=CHUNK.most).stream_reader(
        file, read_across_frames=True
    ),
}
_FAULTS: Final = (OSError, EOFError, RuntimeError, ValueError, zlib.error, zstandard.ZstdError)
"""Exceptions of these libraries for damaged data; OSError is raised by bz2, and by gzip for a wrong checksum."""


class TruncatedFile(LogError):
    """The file ends early, is damaged, or exceeds a limit; everything before that was read."""

    def __init__(self, place: object, note: str) -> None:
        super().__init__(f"{place}: {note}")
        self.note = note
        """The message without the file's name."""


class TooMuch(Exception):
    """The data exceed a limit; the message is one clause. The readers catch it."""


class DamagedChunk(Exception):
    """A chunk that cannot be unpacked. The readers catch it."""


@dataclass(slots=True)
class Losses:
    """Counts parts of a file that could not be read, although the file continues."""

    place: object
    part: str
    """Name of the counted things, in the singular."""
    count: int = 0
    first: str = ""

    def add(self, where: str) -> None:
        """Count one, at this place in the file."""
        self.first = self.first or where
        self.count += 1

    def end(self, ending: str = "") -> None:
        """Raise TruncatedFile if a part was lost, or for an ``ending``, the reason why reading stopped."""
        lost = f"{self.count} damaged {self.part}{'s' * (self.count != 1)} skipped (first at {self.first})"
        if notes := [note for note in (lost if self.count else "", ending) if note]:
            raise TruncatedFile(self.place, ", and ".join(notes))


class Unpacker:
    """Unpacks the data of one file, which in total stay within the limits."""

    def __init__(self) -> None:
        self._packed = self._unpacked = 0

    def chunk(self, packing: str, data: bytes) -> bytes:
        """Unpack a whole chunk; DamagedChunk for other data, KeyError for another packing, TooMuch beyond a limit."""
        opener = _OPENERS[packing]
        self._packed += len(data)
        most = min(CHUNK.most, self._left())
        try:
            unpacked: bytes = opener(io.BytesIO(data)).read(most + 1)
        except _FAULTS as error:
            raise DamagedChunk(str(error)) from error
        if excess := CHUNK.excess(len(unpacked), "in one chunk"):
            raise TooMuch(f"unpacks to {excess}")
        self._count(len(unpacked))
        return unpacked

    def blocks(self, packing: str, file: IO[bytes]) -> Iterator[bytes]:
        """Unpack a whole file, in blocks; DamagedChunk if it ends early, TooMuch beyond a limit."""
        packed = _CountedFile(file)
        stream = _OPENERS[packing](packed)
        while True:
            try:
                block = stream.read1(_BLOCK) if packing == "gzip" else stream.read(_BLOCK)
            except _FAULTS as error:
                raise DamagedChunk(str(error)) from error
            if not block:
                return
            self._packed = packed.count
            self._count(len(block))
            yield block

    def _left(self) -> int:
        """Bytes that may still be unpacked."""
        most = max(UNPACKED_AT_ONCE.most, UNPACKED_PER_BYTE.most * self._packed)
        return max(min(most, UNPACKED.most) - self._unpacked, 0)

    def _count(self, size: int) -> None:
        left = self._left()
        self._unpacked += size
        if size <= left:
            return
        if excess := UNPACKED.excess(self._unpacked):
            raise TooMuch(excess)
        raise TooMuch(f"unpacks to {UNPACKED_PER_BYTE.excess(self._unpacked / max(self._packed, 1))}")


class _CountedFile(io.RawIOBase):
    """A file that counts the bytes read from it."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self.count = 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: bytearray | memoryview) -> int:  # type: ignore[override]
        data = self._file.read(len(buffer))
        self.count += len(data)
        buffer[: len(data)] = data
        return len(data)
