"""The standard streams of a program that somebody sits or reads at."""

from __future__ import annotations

import os
import stat
from typing import Final

_NAMES: Final = {0: "standard input", 1: "standard output", 2: "standard error"}


def watched_streams() -> dict[int, str]:
    """Names by file descriptor: of the terminal, and of pipes and sockets by which the output is read.

    Standard input from a file or a pipe is not among them.
    """
    return {fd: name for fd, name in _NAMES.items() if os.isatty(fd) or (fd > 0 and _has_reader(fd))}


def _has_reader(fd: int) -> bool:
    try:
        mode = os.fstat(fd).st_mode
    except OSError:  # it was closed before the program began
        return False
    return stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)
