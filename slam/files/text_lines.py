"""The lines of a text file, plain or gzip, of any size."""

from collections.abc import Generator, Iterable, Iterator
from io import BufferedReader
from pathlib import Path
from typing import Final

from slam.errors import LogError
from slam.files.unpacking import DamagedChunk, TooMuch, TruncatedFile, Unpacker
from slam.limits import LINE

_BLOCK: Final = 1 << 16
_GZIP_MAGIC: Final = b"\x1f\x8b"


def read_lines(path: Path) -> Generator[tuple[int, bytes], None, None]:
    """Yield the lines of a file, without their ends, numbered from 1; gzip is recognised by its first bytes.

    Raises LogError if the file cannot be read, and TruncatedFile after the last whole line of a gzip file that is
    damaged, or unpacks to more than the limits allow.
    """
    try:
        if not path.is_file():
            raise LogError(f"{path}: {'not a file' if path.exists() else 'no such file'}; check its path")
        with path.open("rb") as file:
            yield from enumerate(_split(_blocks(file, path)), 1)
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror or error}") from error


def _blocks(file: BufferedReader, path: Path) -> Iterator[bytes]:
    if not file.peek(len(_GZIP_MAGIC)).startswith(_GZIP_MAGIC):
        while block := file.read1(_BLOCK):
            yield block
        return
    try:
        yield from Unpacker().blocks("gzip", file)
    except DamagedChunk as error:
        note = "the gzip data are damaged or end early, and what comes after that is lost"
        raise TruncatedFile(path, note) from error
    except TooMuch as excess:
        raise TruncatedFile(path, f"the gzip data are read no further: {excess}") from None


def _split(blocks: Iterable[bytes]) -> Iterator[bytes]:
    tail = b""
    for block in blocks:
        *whole, tail = (tail + block).split(b"\n")
        yield from whole
        tail = tail[: LINE.most]
    if tail:
        yield tail
