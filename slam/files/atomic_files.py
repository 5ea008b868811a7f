"""Files that survive a crash: whole ones appear at once or not at all, growing ones can be read at every moment."""

import errno
import json
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, Final

from slam.closing import Closing
from slam.errors import InputError, StorageError

_FAILING_DISK: Final = {errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EFBIG}


def write_atomic(path: Path, text: str) -> None:
    """Write a text file so that a reader finds the old content or the new, never a part: write, fsync, rename."""
    with atomic_file(path) as draft, draft.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def require_writable(path: Path | None, remedy: str) -> Iterator[None]:
    """Raise an error that ends with the remedy where the path (None: any file) cannot be written in the block:
    StorageError where the disk is full or fails, else InputError."""
    try:
        yield
    except OSError as error:
        kind = StorageError if error.errno in _FAILING_DISK else InputError
        reason = error.strerror or error
        raise kind(f"{path or error.filename}: cannot be written: {reason}; {remedy}") from error


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """A draft to write to, which takes the name ``path`` when the block is left without an error."""
    draft = path.with_name(f".draft-{path.name}")
    try:
        yield draft
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """A place to make and fill a folder, which moves to ``path`` when the block is left without an error."""
    drafts = path.with_name(f".draft-{path.name}")
    shutil.rmtree(drafts, ignore_errors=True)
    drafts.mkdir()
    try:
        yield drafts / path.name
        (drafts / path.name).rename(path)
    finally:
        shutil.rmtree(drafts, ignore_errors=True)


class _GrowingFile(Closing):
    _file: IO[Any]

    def close(self) -> None:
        """Put everything on the disk."""
        os.fsync(self._file.fileno())
        self._file.close()


class GrowingText(_GrowingFile):
    """A text file to which whole lines are appended; each is handed to the system at once."""

    def __init__(self, path: Path, header: str = "") -> None:
        self._file = path.open("w", encoding="utf-8")
        self.append(header)

    def append(self, text: str) -> None:
        """Append text that ends with a line end."""
        self._file.write(text)
        self._file.flush()


def line_feature(coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    """A GeoJSON feature: a LineString through these coordinates."""
    return {
        "type": "Feature",
        "geometry": {"type": "LineString", "coordinates": coordinates},
        "properties": properties,
    }


class GrowingGeoJson(_GrowingFile):
    """A GeoJSON FeatureCollection that is valid after every append: the new features overwrite its closing brackets."""

    _CLOSE = b"\n]}\n"

    def __init__(self, path: Path, **members: Any) -> None:
        head = json.dumps({"type": "FeatureCollection", **members, "features": []})
        self._file = path.open("wb", buffering=0)
        self._file.write(head.removesuffix("]}").encode() + self._CLOSE)
        self._empty = True

    def append(self, features: Iterable[dict[str, Any]]) -> None:
        """Append features, in one write."""
        text = ",\n".join(json.dumps(feature) for feature in features)
        if text:
            self._file.seek(-len(self._CLOSE), os.SEEK_END)
            self._file.write(("\n" if self._empty else ",\n").encode() + text.encode() + self._CLOSE)
            self._empty = False
