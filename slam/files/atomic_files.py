"""Files that survive a crash: complete ones appear at once, growing ones can be read at any time."""

import json
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Final
from zlib import crc32

from slam.closing import Closing
from slam.files.disk import WholeFile, disk, storage_error

DRAFT: Final = ".draft-"
"""Prefix of files and folders that are not complete yet."""


def write_atomic(path: Path, text: str) -> None:
    """Write a text file so that a reader finds the old content or the new, never a part: write, fsync, rename."""
    with atomic_file(path) as draft, closing(WholeFile(draft)) as file:
        file.write(text.encode())


@contextmanager
def require_writable(path: Path | None, remedy: str) -> Iterator[None]:
    """Turn an OSError of the block into one line that ends with advice; ``path`` None means the file that failed.

    Raises StorageError for a disk that fails or is full, InputError for a path that cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise storage_error(error, path, remedy) from error


def _draft_of(path: Path) -> Path:
    """Return the name of a draft in the same folder, short for every length of name, and with the same suffix."""
    return path.with_name(f"{DRAFT}{crc32(os.fsencode(path.name)):08x}{path.suffix[:16]}")


def clear_drafts(folder: Path) -> None:
    """Remove the drafts that killed processes have left in a folder."""
    for left in folder.glob(f"{DRAFT}*"):
        shutil.rmtree(left, ignore_errors=True) if left.is_dir() else left.unlink(missing_ok=True)


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Open a draft, which gets the name ``path`` if the block ends without an error.

    It is synced to the disk before that.
    """
    draft = _draft_of(path)
    try:
        yield draft
        WholeFile(draft, "rb+").close()
        disk().rename(draft, path)
    except OSError as error:
        if error.filename == str(draft):
            error.filename = str(path)  # the user knows this path, not the draft's
        raise
    finally:
        draft.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Make a folder under another name; it moves to ``path`` if the block ends without an error."""
    drafts = _draft_of(path)
    shutil.rmtree(drafts, ignore_errors=True)
    drafts.mkdir()
    try:
        yield drafts / path.name
        disk().rename(drafts / path.name, path)
    finally:
        shutil.rmtree(drafts, ignore_errors=True)


class _GrowingFile(Closing):
    _file: WholeFile

    def close(self) -> None:
        """Sync everything to the disk."""
        self._file.close()


class GrowingText(_GrowingFile):
    """A text file to which whole lines are appended; each is passed to the system at once."""

    def __init__(self, path: Path, header: str = "") -> None:
        self._file = WholeFile(path)
        self.append(header)

    def append(self, text: str) -> None:
        """Append text that ends with a line end."""
        self._file.write(text.encode())


def line_feature(coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    """Make a GeoJSON feature: a LineString through these coordinates."""
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
        self._file = WholeFile(path)
        self._file.write(head.removesuffix("]}").encode() + self._CLOSE)
        self._empty = True

    def append(self, features: Iterable[dict[str, Any]]) -> None:
        """Append features, in one write."""
        text = ",\n".join(json.dumps(feature) for feature in features)
        if text:
            opening = "\n" if self._empty else ",\n"
            self._file.write(opening.encode() + text.encode() + self._CLOSE, back=len(self._CLOSE))
            self._empty = False
