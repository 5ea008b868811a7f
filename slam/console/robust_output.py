"""Standard output that may fail while the program runs: ``| head``, a full disk, a closed terminal."""

import errno
import io
import os
import signal
import sys
from typing import Any, Final

_BROKEN_PIPE: Final = 128 + signal.SIGPIPE
"""Exit code that a shell reports for a program that SIGPIPE has ended."""


class RobustFile(io.FileIO):
    """A file whose writes never fail: after the first error, data is dropped."""

    error: OSError | None = None
    """The first error, if any."""
    dropped = False
    """True once data was dropped."""

    def write(self, data: Any) -> int:
        """Write the bytes, and return how many."""
        if self.error is None:
            try:
                return super().write(data) or 0
            except OSError as error:
                self.error = error
        self.dropped = True
        return len(data)


class RobustOutput:
    """Replaces ``sys.stdout`` and ``sys.stderr`` by streams whose writes never fail.

    That includes files that were closed before the program began.
    """

    def __init__(self) -> None:
        closed = _open_standard_files()
        self._output = RobustFile(1, "w", closefd=False)
        if 1 in closed:
            self._output.error = OSError(errno.EBADF, "it was closed")
        if sys.stdout is sys.__stdout__:  # unless a test has replaced it
            sys.stdout = _text(self._output, sys.stdout)
            sys.stderr = _text(RobustFile(2, "w", closefd=False), sys.stderr)

    def exit_code(self) -> int:
        """Return 0 if all output was written, 141 if its reader has ended, and 1, after a message, otherwise."""
        sys.stdout.flush()
        error = self._output.error
        if error is None or not self._output.dropped:
            return 0
        if error.errno == errno.EPIPE:
            return _BROKEN_PIPE
        print(f"hopslam: standard output: {error.strerror}; what was printed is not complete", file=sys.stderr)
        return 1


def _open_standard_files() -> list[int]:
    """Open those of the files 0, 1 and 2 that are closed, so that no later file gets their number.

    Return their numbers.
    """
    closed = []
    while (free := os.open(os.devnull, os.O_RDWR)) <= 2:
        closed.append(free)
    os.close(free)
    return closed


def _text(file: RobustFile, before: Any) -> io.TextIOWrapper:
    """Make a text stream on this file, with the encoding of the stream before it, if there was one."""
    encoding, errors = ("utf-8", "replace") if before is None else (before.encoding, before.errors)
    if before is not None:
        before.flush()
    is_error = file.fileno() == 2
    return io.TextIOWrapper(io.BufferedWriter(file), encoding, errors, line_buffering=is_error or file.isatty())
