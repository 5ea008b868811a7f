"""Lock on an open file, which the system releases when the process ends."""

import os
import sys
from typing import IO, Any, Final

_FAR_BYTE: Final = 1 << 30
"""Position of the byte that is locked on Windows, far from the text, because nobody can read locked bytes there."""


def try_lock(file: IO[Any]) -> bool:
    """Lock a file for this process until it is closed; return False if another process has locked it."""
    try:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(file.fileno(), _FAR_BYTE, os.SEEK_SET)
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    return True
