"""What stops the robot when the program that drives it ends, is suspended, fails, or loses its terminal."""

from __future__ import annotations

import os
import select
import signal
import stat
import sys
import threading
from collections.abc import Callable
from typing import Any, Final

from hardware.stop_signals import StopSignals
from slam.closing import Closing
from slam.errors import OutputLost, RobotError

_CLOSE: Final = 0
"""Number that no signal has: it ends the thread."""
_STREAMS: Final = {0: "standard input", 1: "standard output", 2: "standard error"}

Stop = Callable[[str, RobotError | None], None]


class ProcessWatch(Closing):
    """Watches this process on a thread of its own, whatever the main thread is doing.

    ``end(reason, error)`` is called once the program was told to end, has lost its terminal or the reader of its
    output, or one of its threads ended by an exception; ``error`` is what the robot should raise from then on, None
    where the program ends by itself. ``suspend(reason)`` is called before the program is suspended, which then happens,
    and after it was. What ends a process without a signal that it can handle, SIGKILL and SIGSTOP, is not seen.
    """

    def __init__(self, end: Stop, suspend: Callable[[str], None]) -> None:
        self._end, self._suspend = end, suspend
        self._wake, self._wakeup = os.pipe()
        os.set_blocking(self._wakeup, False)
        self._poll = select.poll()
        self._poll.register(self._wake, select.POLLIN)
        for stream in _watched_streams():
            self._poll.register(stream, 0)  # errors and hang-ups, which poll always reports
        self._signals = StopSignals(self._wakeup)
        self._hooks = threading.excepthook, sys.excepthook
        self._thread = threading.Thread(target=self._watch, name="process watch", daemon=True)
        self._thread.start()
        self._signals.install()
        threading.excepthook, sys.excepthook = self._thread_failed, self._program_failed

    def close(self) -> None:
        """Watch no more; closing twice is allowed."""
        if self._thread.is_alive():
            self._signals.remove()
            threading.excepthook, sys.excepthook = self._hooks
            os.write(self._wakeup, bytes([_CLOSE]))
            self._thread.join()
            os.close(self._wake)
            os.close(self._wakeup)

    def _watch(self) -> None:
        while True:
            for fd, _ in self._poll.poll():
                if fd != self._wake:
                    self._lose(fd)
                elif not self._receive(os.read(fd, 64)):
                    return

    def _lose(self, stream: int) -> None:
        self._poll.unregister(stream)
        reason = f"{_STREAMS[stream]} is gone"
        self._end(reason, OutputLost(f"{reason}, so nobody watches the robot: it was stopped; send output to a file"))

    def _receive(self, numbers: bytes) -> bool:
        """Act on these signals; False once the watch is closed."""
        for number in numbers:
            if number == _CLOSE:
                return False
            self._act(number)
        self._signals.pass_on(numbers)
        return True

    def _act(self, number: int) -> None:
        if number in self._signals.ending:
            self._end(f"the program got {signal.Signals(number).name}", None)
        elif number in self._signals.suspending:
            self._suspend("the program is suspended")
            os.kill(os.getpid(), signal.SIGSTOP)
        elif number == signal.SIGCONT:
            self._suspend("the program was suspended")

    def _thread_failed(self, failure: threading.ExceptHookArgs) -> None:
        if not issubclass(failure.exc_type, SystemExit):
            name = failure.thread.name if failure.thread else "unknown"
            reason = f"thread {name!r} failed: {failure.exc_type.__name__}: {failure.exc_value}"
            self._end(reason, RobotError(f"{reason}; the robot was stopped"))
        self._hooks[0](failure)

    def _program_failed(self, kind: type[BaseException], *rest: Any) -> None:
        self._end(f"the program failed: {kind.__name__}", None)
        self._hooks[1](kind, *rest)


def _watched_streams() -> list[int]:
    """The terminal, and whatever reads the output: pipes and sockets; not standard input from a file or a pipe."""
    return [stream for stream in _STREAMS if os.isatty(stream) or (stream > 0 and _has_reader(stream))]


def _has_reader(stream: int) -> bool:
    try:
        mode = os.fstat(stream).st_mode
    except OSError:  # it was closed before the program began
        return False
    return stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)
