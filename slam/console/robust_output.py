"""Standard output that may fail while the program runs: ``| head``, a full disk, a closed terminal."""

import errno
import io
import os
import sys
from typing import Any

from slam.errors import OutputLost
from slam.system import reader_has_ended


class RobustFile(io.RawIOBase):
    """A file whose writes never fail: after the first error, data is dropped.

    The descriptor stays open. It is written to by Python's ``open``, which also supports the console of Windows.
    """

    def __init__(self, descriptor: int) -> None:
        self._raw = open(descriptor, "wb", buffering=0, closefd=False)  # noqa: SIM115
        self.error: OSError | None = None
        """The first error, if any."""
        self.dropped = False
        """True once data was dropped."""

    def write(self, data: Any) -> int:
        """Write the bytes, and return how many."""
        if self.error is None:
            try:
                return self._raw.write(data) or 0
            except OSError as error:
                self.error = error
        self.dropped = True
        return len(data)

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._raw.fileno()

    def isatty(self) -> bool:
        return self._raw.isatty()


class RobustOutput:
    """Replaces ``sys.stdout`` and ``sys.stderr`` by streams whose writes never fail.

    That includes files that were closed before the program began.
    """

    def __init__(self) -> None:
        closed = _open_standard_files()
        self._output = RobustFile(1)
        if 1 in closed:
            self._output.error = OSError(errno.EBADF, "it was closed")
        if sys.stdout is sys.__stdout__:  # False if a test has replaced it
            sys.stdout = _text(self._output, sys.stdout)
            sys.stderr = _text(RobustFile(2), sys.stderr)

    def exit_code(self) -> int:
        """Return 0 if all output was written, 141 if its reader has ended, and 1, after a message, otherwise."""
        sys.stdout.flush()
        error = self._output.error
        if error is None or not self._output.dropped:
            return 0
        if reader_has_ended(error):
            return OutputLost.exit_code
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
    """Make a text stream on this file, with the encoding of the stream before it, if there was one.

    Characters that the encoding lacks, such as the frames of tables in cp1252, are written as question marks.
    """
    if before is not None:
        before.flush()
    encoding = "utf-8" if before is None else before.encoding
    is_error = file.fileno() == 2
    return io.TextIOWrapper(io.BufferedWriter(file), encoding, "replace", line_buffering=is_error or file.isatty())
