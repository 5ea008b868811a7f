"""The lines of a text file, plain or gzip, of any size."""

import gzip
import zlib
from collections.abc import Generator, Iterable, Iterator
from io import BufferedReader
from pathlib import Path
from typing import Final

from slam.errors import LogError

LONGEST_LINE: Final = 1 << 18
"""Bytes; the rest of a longer line is dropped. A scan of 682 beams takes 4096."""
_BLOCK: Final = 1 << 16
_GZIP_MAGIC: Final = b"\x1f\x8b"


class TruncatedFile(LogError):
    """The file ends early or is damaged; what came before has been read."""


def read_lines(path: Path) -> Generator[tuple[int, bytes], None, None]:
    """The lines of a file, without their ends, numbered from 1; gzip is known by its first bytes.

    Raises LogError when the file cannot be read, and TruncatedFile after the last whole line of a damaged gzip file.
    """
    try:
        if not path.is_file():
            raise LogError(f"{path}: {'not a file' if path.exists() else 'no such file'}; give a recorded log")
        with path.open("rb") as file:
            yield from enumerate(_split(_blocks(file, path)), 1)
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror or error}") from error


def _blocks(file: BufferedReader, path: Path) -> Iterator[bytes]:
    gzipped = file.peek(len(_GZIP_MAGIC)).startswith(_GZIP_MAGIC)
    stream = gzip.GzipFile(fileobj=file) if gzipped else file
    try:
        while block := stream.read1(_BLOCK):
            yield block
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise TruncatedFile(f"{path}: the gzip data are damaged or end early") from error


def _split(blocks: Iterable[bytes]) -> Iterator[bytes]:
    tail = b""
    for block in blocks:
        *whole, tail = (tail + block).split(b"\n")
        yield from whole
        tail = tail[:LONGEST_LINE]
    if tail:
        yield tail
