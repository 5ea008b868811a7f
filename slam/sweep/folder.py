"""A folder by path or by URL, in which files appear at once or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Any, Final

from slam.errors import InputError, StorageError
from slam.files.atomic_files import DRAFT, clear_drafts, write_atomic
from slam.files.disk import WholeFile, disk
from slam.named_code import import_optional

_ASIDE: Final = ".damaged-"
"""Prefix of files that were set aside."""


class Folder:
    """A folder whose ``address`` is a path, or a URL that fsspec supports, such as ``s3://bucket/sweep``.

    InputError for an unknown kind of URL, or one whose package is not installed.
    """

    def __init__(self, address: str) -> None:
        address = address.removeprefix("file://")
        self.path = None if "://" in address else Path(address).absolute()
        """Path of the folder; None for a URL."""
        self.address = address if self.path is None else str(self.path)
        self._fs: Any = None
        self._root = ""
        if self.path is None:
            self._fs, self._root = _open(address)

    def __truediv__(self, name: str) -> Folder:
        return Folder(f"{self.address.rstrip('/')}/{name}")

    def write(self, name: str, text: str) -> None:
        """Write a small file at once or not at all."""
        if self.path is not None:
            self.path.mkdir(parents=True, exist_ok=True)
            write_atomic(self.path / name, text)
        else:
            self._fs.makedirs(self._root, exist_ok=True)
            self._fs.pipe_file(self._place(name), text.encode())

    def read(self, name: str) -> str | None:
        """Read the text of a file; None if there is none."""
        try:
            if self.path is not None:
                return (self.path / name).read_text(encoding="utf-8")
            return str(self._fs.cat_file(self._place(name)).decode())
        except FileNotFoundError:
            return None

    def names(self) -> list[str]:
        """Return names of the files in it, sorted, without drafts; empty if there is no such folder."""
        try:
            if self.path is not None:
                found = [entry.name for entry in os.scandir(self.path)]
            else:
                found = [str(place).rsplit("/", 1)[-1] for place in self._fs.ls(self._root, detail=False, refresh=True)]
        except FileNotFoundError:
            return []
        return sorted(name for name in found if not name.startswith("."))

    def open(self, name: str) -> IO[bytes]:
        """Open a file for reading; FileNotFoundError if there is none."""
        if self.path is not None:
            return (self.path / name).open("rb")
        file: IO[bytes] = self._fs.open(self._place(name), "rb")
        return file

    @contextmanager
    def draft(self) -> Iterator[Path]:
        """Make a temporary folder for ``move_in``: inside this folder, or on this machine if the folder is at a URL."""
        if self.path is not None:
            self.path.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=DRAFT, dir=self.path, ignore_cleanup_errors=True) as draft:
            yield Path(draft)

    def move_in(self, draft: Path, name: str) -> None:
        """Move a file or folder from a draft to this name here, and replace an older one."""
        if self.path is None:
            self._fs.makedirs(self._root, exist_ok=True)
            if draft.is_dir() and self._fs.exists(self._place(name)):
                self._fs.rm(self._place(name), recursive=True)  # otherwise the folder would be moved into it
            self._fs.put(str(draft), self._place(name), recursive=draft.is_dir())
            return
        place = self.path / name
        if draft.is_file():
            WholeFile(draft, "rb+").close()  # puts it on the disk
        elif place.is_symlink():
            place.unlink()
        elif place.is_dir():
            shutil.rmtree(place)
        disk().rename(draft, place)

    def clear_drafts(self) -> None:
        """Remove the drafts that killed processes have left."""
        if self.path is not None:
            clear_drafts(self.path)

    def set_aside(self, name: str) -> str:
        """Move a damaged file aside, in this folder; return its new address."""
        aside = f"{_ASIDE}{name}"
        if self.path is not None:
            (self.path / name).replace(self.path / aside)
        else:
            self._fs.mv(self._place(name), self._place(aside))
        return f"{self.address}/{aside}"

    def remove(self, name: str) -> None:
        """Remove a file, if it exists."""
        if self.path is not None:
            (self.path / name).unlink(missing_ok=True)
        elif self._fs.exists(self._place(name)):
            self._fs.rm_file(self._place(name))

    def _place(self, name: str) -> str:
        return f"{self._root}/{name}"


def _open(url: str) -> tuple[Any, str]:
    """Return the file system of a URL, and the path in it."""
    fsspec = import_optional("fsspec", "sweep")
    try:
        fs, root = fsspec.core.url_to_fs(url)
    except (ValueError, ImportError) as error:
        raise InputError(f"{url}: {error}") from error
    except Exception as error:
        raise StorageError(f"{url}: cannot be reached: {error}") from error
    return fs, str(root).rstrip("/")
