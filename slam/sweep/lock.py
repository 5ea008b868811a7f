"""Lock of a sweep's folder for a single driver."""

import json
import os
import platform
from typing import IO, Any, Final, Self

from slam.errors import InputError
from slam.files.file_lock import try_lock
from slam.sweep.folder import Folder
from slam.system import is_running

_NAME: Final = "driver.lock"


class SweepLock:
    """Lock of a folder for one driver; InputError while another driver has it.

    On a file system the system holds it, and releases it when the process dies. At a URL it is a file with host and
    process: the lock of a dead process of this host is taken over.
    """

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        self._file: IO[str] | None = None
        self._me = json.dumps({"host": platform.node(), "pid": os.getpid()})

    def __enter__(self) -> Self:
        if self._folder.path is not None:
            self._lock_file()
        else:
            self._write_claim()
        return self

    def __exit__(self, *exc_info: object) -> None:
        if self._file is not None:
            self._file.close()
        else:
            self._folder.remove(_NAME)

    def _lock_file(self) -> None:
        assert self._folder.path is not None
        self._folder.path.mkdir(parents=True, exist_ok=True)
        self._file = (self._folder.path / _NAME).open("a+", encoding="utf-8", errors="replace")
        if not try_lock(self._file):
            self._file.seek(0)
            with self._file:
                raise self._refusal(self._file.read())
        self._file.truncate(0)
        self._file.write(self._me)
        self._file.flush()

    def _write_claim(self) -> None:
        other = self._folder.read(_NAME)
        if other is not None and _may_run(other):
            raise self._refusal(other)
        self._folder.write(_NAME, self._me)

    def _refusal(self, other: str) -> InputError:
        who = _claim(other)
        return InputError(
            f"{self._folder.address}: process {who.get('pid')} on {who.get('host')} runs a sweep there; wait for it, "
            f"or choose another --out (if it is gone, remove {_NAME})"
        )


def _claim(text: str) -> dict[str, Any]:
    """Read host and process of a lock; empty if it cannot be read."""
    try:
        claim = json.loads(text)
    except ValueError:
        return {}
    return claim if isinstance(claim, dict) else {}


def _may_run(other: str) -> bool:
    """Return True if that process may still run: one of another host counts as running."""
    who = _claim(other)
    if who.get("host") != platform.node() or not isinstance(who.get("pid"), int):
        return True
    return is_running(who["pid"])
