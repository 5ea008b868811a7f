"""Differences between operating systems: processes, signals, pipes, memory."""

import errno
import os
import signal
import sys
from math import nan
from typing import Final

ENDING_SIGNALS: Final = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK") if hasattr(signal, name)
)
"""Signals of Ctrl-C, ``kill``, a closed terminal and Ctrl-Backslash; Windows has SIGBREAK for the last two."""
_SYNCHRONIZE: Final = 0x00100000
"""Access right to wait for the end of a process (Windows)."""


def usable_cores() -> int:
    """Return the number of processors that this program may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def leave_terminal() -> None:
    """Leave Ctrl-C to the parent, which then ends this process; call it first in a new process."""
    if sys.platform == "win32":
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGBREAK, signal.SIG_IGN)
    else:
        os.setsid()


def is_running(process: int) -> bool:
    """Return True if a process of this machine runs, or if this user may not ask."""
    try:
        if sys.platform == "win32":
            import _winapi  # os.kill would send Ctrl-C instead

            handle = _winapi.OpenProcess(_SYNCHRONIZE, False, process)
            ended = _winapi.WaitForSingleObject(handle, 0) == _winapi.WAIT_OBJECT_0
            _winapi.CloseHandle(handle)
            return not ended
        os.kill(process, 0)
    except (PermissionError, OverflowError):
        return True
    except OSError:
        return False
    return True


def reader_has_ended(error: OSError) -> bool:
    """Return True if writing failed because nobody reads the pipe; Windows reports an invalid argument."""
    return error.errno == errno.EPIPE or (sys.platform == "win32" and error.errno == errno.EINVAL)


def peak_memory(of_children: bool = False) -> float:
    """Return the peak memory of this process, or of the largest child that it waited for, bytes; nan on Windows."""
    if sys.platform == "win32":
        return nan
    import resource

    peak = resource.getrusage(resource.RUSAGE_CHILDREN if of_children else resource.RUSAGE_SELF).ru_maxrss
    return float(peak) if sys.platform == "darwin" else 1024.0 * peak  # Linux counts kB
