"""A disk of which one call fails, for tests."""

import os
from io import FileIO
from pathlib import Path

from slam.files.disk import Disk


class FaultyDisk(Disk):
    """Counts all calls; call number ``at`` fails with the error number ``fault``, or writes only half if that is None.

    With ``forever``, all calls after it fail too, as on a disk that is full.
    """

    def __init__(self, at: int = -1, fault: int | None = None, forever: bool = False) -> None:
        self.calls: list[str] = []
        self._at, self._fault, self._forever = at, fault, forever

    def open(self, path: Path, mode: str = "wb+") -> FileIO:
        self._count(f"open {path.name}", path)
        return super().open(path, mode)

    def write(self, file: FileIO, data: bytes) -> int:
        if self._is_next():
            written = super().write(file, data[: (len(data) + 1) // 2])
            if self._fault is None:
                self.calls.append("short write")
                return written
        self._count("write", file.name)
        return super().write(file, data)

    def sync(self, file: FileIO) -> None:
        self._count("sync", file.name)
        super().sync(file)

    def close(self, file: FileIO) -> None:
        self._count("close", file.name)
        super().close(file)

    def rename(self, draft: Path, path: Path) -> None:
        self._count(f"rename {path.name}", path)
        super().rename(draft, path)

    def _is_next(self) -> bool:
        number = len(self.calls)
        return number == self._at or (self._forever and 0 <= self._at < number)

    def _count(self, call: str, path: object) -> None:
        failing = self._is_next() and self._fault is not None
        self.calls.append(call)
        if failing and self._fault is not None:
            raise OSError(self._fault, os.strerror(self._fault), str(path))
