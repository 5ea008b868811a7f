"""Stops robots when the program that drives them ends, is suspended, fails, or loses its terminal."""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final, NamedTuple

from hardware.stop_signals import StopSignals
from hardware.watched_streams import watched_streams
from slam.errors import OutputLost, RobotError

_CLOSE: Final = 0
"""Number that no signal has: it ends the thread."""
_lock: Final = threading.Lock()
_current: _ProcessWatch | None = None
"""The watch of this process; None while it has no robot."""


class Stop(NamedTuple):
    """Two ways to stop one robot; both may be called from any thread."""

    end: Callable[[str, RobotError | None], None]
    """Stop for good, for this reason; the error is what the robot should raise from then on, if any."""
    suspend: Callable[[str], None]
    """Stop until somebody agrees again, for this reason."""


@contextmanager
def process_watch(stop: Stop) -> Iterator[None]:
    """Watch this process for the robot, on a thread that all robots of the process share, while the block runs.

    ``stop.end`` is called once the program was told to end, has lost its terminal or the reader of its output, or one
    of its threads failed. ``stop.suspend`` is called before the program is suspended, which then happens, and after it
    was. What ends a process without a signal that it can handle, SIGKILL and SIGSTOP, is not seen.
    """
    global _current
    with _lock:
        _current = watch = _current or _ProcessWatch()
        watch.add(stop)
    try:
        yield
    finally:
        with _lock:
            if watch.remove(stop):
                _current = None


class _ProcessWatch:
    """A thread that is woken by numbers of signals on a pipe and by hang-ups of streams, and hooks for exceptions."""

    def __init__(self) -> None:
        self._stops: list[Stop] = []
        self._wake, self._wakeup = os.pipe()
        os.set_blocking(self._wakeup, False)
        self._poll = select.poll()
        self._poll.register(self._wake, select.POLLIN)
        self._streams = watched_streams()
        for stream in self._streams:
            self._poll.register(stream, 0)  # errors and hang-ups, which poll always reports
        self._signals = StopSignals(self._wakeup)
        self._hooks = threading.excepthook, sys.excepthook
        threading.excepthook, sys.excepthook = self._thread_failed, self._program_failed
        self._thread = threading.Thread(target=self._watch, name="process watch", daemon=True)
        self._thread.start()

    def add(self, stop: Stop) -> None:
        """Stop this robot, too."""
        self._stops.append(stop)
        self._signals.install()

    def remove(self, stop: Stop) -> bool:
        """Forget this robot, and return whether it was the last one, so that the watch is over.

        Only the main thread can give the signals back. Without it the watch goes on, with nothing to stop.
        """
        self._stops.remove(stop)
        if self._stops or not self._signals.remove():
            return False
        threading.excepthook, sys.excepthook = self._hooks
        os.write(self._wakeup, bytes([_CLOSE]))
        self._thread.join()
        os.close(self._wake)
        os.close(self._wakeup)
        return True

    def _watch(self) -> None:
        while True:
            for fd, _ in self._poll.poll():
                if fd != self._wake:
                    self._lose(fd)
                elif not self._receive(os.read(fd, 64)):
                    return

    def _lose(self, stream: int) -> None:
        self._poll.unregister(stream)
        reason = f"{self._streams[stream]} is gone"
        self._end(reason, OutputLost(f"{reason}, so nobody watches the robot: it was stopped; send output to a file"))

    def _receive(self, numbers: bytes) -> bool:
        """Act on these signals; False once the watch is over."""
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

    def _end(self, reason: str, error: RobotError | None) -> None:
        for stop in list(self._stops):
            stop.end(reason, error)

    def _suspend(self, reason: str) -> None:
        for stop in list(self._stops):
            stop.suspend(reason)

    def _thread_failed(self, failure: threading.ExceptHookArgs) -> None:
        if not issubclass(failure.exc_type, SystemExit):
            name = failure.thread.name if failure.thread else "unknown"
            reason = f"thread {name!r} failed: {failure.exc_type.__name__}: {failure.exc_value}"
            self._end(reason, RobotError(f"{reason}; the robot was stopped"))
        self._hooks[0](failure)

    def _program_failed(self, kind: type[BaseException], *rest: Any) -> None:
        self._end(f"the program failed: {kind.__name__}", None)
        self._hooks[1](kind, *rest)


def _forget() -> None:
    """A forked child has handlers but no thread, and its signals are not its parent's."""
    global _current
    if _current is not None:
        _current = None
        signal.set_wakeup_fd(-1)


os.register_at_fork(after_in_child=_forget)
