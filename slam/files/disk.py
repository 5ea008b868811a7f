"""System calls that change the files of results: all use one object, which tests replace."""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path
from time import monotonic, sleep
from typing import Final

from slam.errors import HopslamError, InputError, StorageError

_FAILING: Final = {errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EPIPE, errno.ESTALE, errno.EFBIG}
"""Errors of a disk, a network or a pipe; all others concern the path that was given."""

_PATIENCE: Final = 2.0
"""Seconds to wait on Windows until a file can be replaced: another program, such as a virus scanner, may read it."""


class Disk:
    """Files without buffers: when a call returns, the system has the data."""

    def open(self, path: Path, mode: str = "wb+") -> FileIO:
        """Open a file for writing."""
        return FileIO(path, mode)

    def write(self, file: FileIO, data: bytes) -> int:
        """Write some of the bytes, at least one; return their number."""
        return file.write(data)

    def sync(self, file: FileIO) -> None:
        """Sync everything to the disk."""
        if sys.platform == "darwin":  # fsync does not empty the cache of the drive
            import fcntl

            with suppress(OSError):  # some file systems do not support it
                fcntl.fcntl(file, fcntl.F_FULLFSYNC)
        os.fsync(file.fileno())

    def close(self, file: FileIO) -> None:
        """Close a file; some systems report only here that a write has failed."""
        file.close()

    def rename(self, draft: Path, path: Path) -> None:
        """Rename a file or folder, and replace a file of that name."""
        until = monotonic() + (_PATIENCE if sys.platform == "win32" else 0.0)
        while True:
            try:
                draft.replace(path)
                return
            except PermissionError:
                if monotonic() >= until:
                    raise
                sleep(0.02)


_disks: Final = [Disk()]


def disk() -> Disk:
    """The disk in use."""
    return _disks[-1]


@contextmanager
def using_disk(other: Disk) -> Iterator[None]:
    """Let all files of the block use another disk."""
    _disks.append(other)
    try:
        yield
    finally:
        _disks.remove(other)


class WholeFile:
    """A file to which pieces are appended, each as a whole or not at all.

    This holds as long as the system lets a file be truncated.
    """

    def __init__(self, path: Path, mode: str = "wb+") -> None:
        self._file = disk().open(path, mode)

    def write(self, piece: bytes, back: int = 0) -> int:
        """Write at the end, over the last ``back`` bytes; return the length.

        After an error the file is as before, or removed if this was its first piece.
        """
        place = self._file.seek(-back, os.SEEK_END)
        last, left = self._last(back), memoryview(piece)
        try:
            while left:
                left = left[disk().write(self._file, bytes(left)) :]
        except OSError as error:
            self._file.truncate(place)
            self._file.seek(place)
            self._file.write(last)
            if not place:
                Path(self._file.name).unlink(missing_ok=True)  # an empty file is not a complete one
            raise self._named(error) from None
        return len(piece)

    def flush(self) -> None:
        """Do nothing: there is no buffer."""

    def tell(self) -> int:
        """Length of the file, bytes."""
        return self._file.tell()

    def close(self) -> None:
        """Sync everything to the disk, and close, whatever fails."""
        if self._file.closed:
            return
        try:
            disk().sync(self._file)
        except OSError as error:
            raise self._named(error) from None
        finally:
            try:
                disk().close(self._file)
            finally:
                self._file.close()

    def __del__(self) -> None:
        """Close and remove a file whose first piece failed."""
        if hasattr(self, "_file"):
            self._file.close()

    def _named(self, error: OSError) -> OSError:
        """Return the error with the name of the file, which the system leaves out."""
        return OSError(error.errno, error.strerror, str(self._file.name))

    def _last(self, count: int) -> bytes:
        if not count:
            return b""
        last = self._file.read(count)
        self._file.seek(-len(last), os.SEEK_CUR)
        return last


@contextmanager
def failing_disk(remedy: str) -> Iterator[None]:
    """Turn an OSError of a failing or full disk into a StorageError, one line that ends with advice."""
    try:
        yield
    except OSError as error:
        if error.errno not in _FAILING:
            raise
        raise storage_error(error, None, remedy) from error


def storage_error(error: OSError, path: Path | None, remedy: str) -> HopslamError:
    """Return StorageError for a disk that fails or is full, InputError for a path that cannot be written."""
    kind = StorageError if error.errno in _FAILING else InputError
    place = path or error.filename or "a file"
    return kind(f"{place}: cannot be written: {error.strerror or error}; {remedy}")
