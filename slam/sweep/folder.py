"""A folder by path or by URL: files in it appear at once or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Any, Final

from slam.errors import InputError, StorageError
from slam.files.whole_files import write_whole
from slam.named_code import import_optional

_DRAFT: Final = ".draft-"


class Folder:
    """``address`` is a path, or a URL of any kind that fsspec knows, such as ``s3://bucket/sweep``.

    InputError where it is of a kind that is not known, or whose package is not installed.
    """

    def __init__(self, address: str) -> None:
        address = address.removeprefix("file://")
        self.path = None if "://" in address else Path(address).absolute()
        """None where it is a URL."""
        self.address = address if self.path is None else str(self.path)
        self._remote = None if self.path is not None else _open(address)

    def __truediv__(self, name: str) -> Folder:
        return Folder(f"{self.address.rstrip('/')}/{name}")

    def write(self, name: str, text: str) -> None:
        """Write a small file whole."""
        if self.path is not None:
            self.path.mkdir(parents=True, exist_ok=True)
            write_whole(self.path / name, text)
        else:
            self._fs.makedirs(self._root, exist_ok=True)
            self._fs.pipe_file(self._place(name), text.encode())

    def read(self, name: str) -> str | None:
        """The text of a file; None where there is none."""
        try:
            return str(self._fs.cat_file(self._place(name)).decode()) if self.path is None else self._read(name)
        except FileNotFoundError:
            return None

    def names(self) -> list[str]:
        """Of the files in it, sorted, without drafts; none where there is no such folder."""
        try:
            if self.path is not None:
                found = [entry.name for entry in os.scandir(self.path)]
            else:
                found = [str(place).rsplit("/", 1)[-1] for place in self._fs.ls(self._root, detail=False, refresh=True)]
        except FileNotFoundError:
            return []
        return sorted(name for name in found if not name.startswith("."))

    def open(self, name: str) -> IO[bytes]:
        """A file to read from; FileNotFoundError where there is none."""
        if self.path is not None:
            return (self.path / name).open("rb")
        file: IO[bytes] = self._fs.open(self._place(name), "rb")
        return file

    @contextmanager
    def draft(self) -> Iterator[Path]:
        """A new folder on this machine, for what ``take_in`` then gets: on the same file system, if this is on one."""
        if self.path is not None:
            self.path.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=_DRAFT, dir=self.path, ignore_cleanup_errors=True) as draft:
            yield Path(draft)

    def take_in(self, draft: Path, name: str) -> None:
        """A file or a folder in a draft of this one gets this name here, in the place of what had it."""
        if self.path is None:
            self._send(draft, self._place(name))
            return
        place = self.path / name
        if draft.is_file():
            _onto_the_disk(draft)
        elif place.is_dir():
            shutil.rmtree(place)
        draft.replace(place)

    def clear_drafts(self) -> None:
        """Remove what processes that were killed have left."""
        for left in self.path.glob(f"{_DRAFT}*") if self.path is not None else ():
            shutil.rmtree(left, ignore_errors=True)

    def remove(self, name: str) -> None:
        """Of a file that may be gone already."""
        if self.path is not None:
            (self.path / name).unlink(missing_ok=True)
        elif self._fs.exists(self._place(name)):
            self._fs.rm_file(self._place(name))

    def _send(self, draft: Path, place: str) -> None:
        self._fs.makedirs(self._root, exist_ok=True)
        if draft.is_dir() and self._fs.exists(place):
            self._fs.rm(place, recursive=True)  # else the folder would be put into it
        self._fs.put(str(draft), place, recursive=draft.is_dir())

    @property
    def _fs(self) -> Any:
        assert self._remote is not None
        return self._remote[0]

    @property
    def _root(self) -> str:
        assert self._remote is not None
        return str(self._remote[1]).rstrip("/")

    def _place(self, name: str) -> str:
        return f"{self._root}/{name}"

    def _read(self, name: str) -> str:
        assert self.path is not None
        return (self.path / name).read_text(encoding="utf-8")


def _onto_the_disk(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _open(url: str) -> tuple[Any, str]:
    fsspec = import_optional("fsspec", "sweep")
    try:
        fs, root = fsspec.core.url_to_fs(url)
    except (ValueError, ImportError) as error:
        raise InputError(f"{url}: {error}") from error
    except Exception as error:
        raise StorageError(f"{url}: cannot be reached: {error}") from error
    return fs, root
