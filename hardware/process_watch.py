"""Stops robots when the program that drives them ends, is suspended, fails, or loses its terminal."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any, Final, NamedTuple

from hardware.stop_signals import CONTINUES, StopSignals, name_of, suspend
from hardware.stream_watch import StreamWatch
from slam.errors import OutputLost, RobotError

_CLOSE: Final = 0
"""Wake-up number that is not a signal; it ends the thread."""
_BEAT: Final = 0.1
"""Seconds between two looks at the clock."""
_GAP: Final = 0.5
"""Seconds; a longer time between two checks shows that the program was suspended. SIGCONT alone does not show that, as
a program also gets it when its terminal is closed."""
_lock: Final = threading.Lock()
_current: _ProcessWatch | None = None
"""The watch of this process; None while it has no robot."""


class StopCallbacks(NamedTuple):
    """Two ways to stop one robot; both may be called from any thread."""

    end: Callable[[str, RobotError | None], None]
    """Stop for good, for this reason; later calls of the robot raise the error, if any."""
    suspend: Callable[[str], None]
    """Stop until somebody agrees again, for this reason."""


@contextmanager
def process_watch(stop: StopCallbacks) -> Iterator[Callable[[], None]]:
    """Watch this process for the robot, on a thread that all robots of the process share, while the block runs.

    ``stop.end`` is called if the program is told to end, loses its terminal or the reader of its output, or one of its
    threads fails. ``stop.suspend`` is called before the program is suspended, and after it. SIGKILL and SIGSTOP cannot
    be handled, and are not seen. Yields a function to call with every command: it takes back signals that an event loop
    has claimed since.
    """
    global _current
    with _lock:
        _current = watch = _current or _ProcessWatch()
        watch.add(stop)
    try:
        yield watch.signals.reclaim
    finally:
        with _lock:
            if watch.remove(stop):
                _current = None


class _ProcessWatch:
    """Thread that is woken by signal numbers at a socket and by hang-ups of streams, and hooks for exceptions."""

    def __init__(self) -> None:
        self._stops: list[StopCallbacks] = []
        self._wake, self._wakeup = socket.socketpair()  # all systems can poll sockets, but not pipes
        self._wakeup.setblocking(False)
        self._streams = StreamWatch(self._wake)
        self._over: tuple[str, RobotError] | None = None
        self._looked_at = monotonic()
        self.signals = StopSignals(self._wakeup.fileno())
        self._hooks = threading.excepthook, sys.excepthook, sys.unraisablehook
        threading.excepthook, sys.excepthook = self._thread_failed, self._program_failed
        sys.unraisablehook = self._call_failed
        self._thread = threading.Thread(target=self._watch, name="process watch", daemon=True)
        self._thread.start()

    def add(self, stop: StopCallbacks) -> None:
        """Stop this robot too; at once if the reader of the output is already gone."""
        self._stops.append(stop)
        self.signals.install()
        if self._over is not None:
            stop.end(*self._over)

    def remove(self, stop: StopCallbacks) -> bool:
        """Forget this robot, and return True if it was the last one, so that the watch ends.

        Only the main thread can restore the signal handlers. Without it the watch goes on, with nothing to stop.
        """
        self._stops.remove(stop)
        if self._stops or not self.signals.remove():
            return False
        threading.excepthook, sys.excepthook, sys.unraisablehook = self._hooks
        self._wakeup.send(bytes([_CLOSE]))
        self._thread.join()
        self._wake.close()
        self._wakeup.close()
        return True

    def _watch(self) -> None:
        while True:
            woken, lost = self._streams.wait(_BEAT)
            for stream in lost:
                self._lose(stream)
            if woken and not self._receive(self._wake.recv(64)):
                return
            self._looked_at = monotonic()

    def _lose(self, stream: str) -> None:
        reason = f"{stream} is gone"
        error = OutputLost(f"{reason}, so nobody watches the robot: it was stopped; send output to a file")
        self._over = reason, error
        self._end(reason, error)

    def _receive(self, numbers: bytes) -> bool:
        """Act on these signals; return False once the watch is over."""
        for number in numbers:
            if number == _CLOSE:
                return False
            self._act(number)
        self.signals.pass_on(numbers)
        return True

    def _act(self, number: int) -> None:
        if number in self.signals.ending:
            self._end(f"the program got {name_of(number)}", None)
        elif number in self.signals.suspending:
            self._suspend("the program is suspended")
            suspend()
        elif number == CONTINUES and monotonic() - self._looked_at > _GAP:
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
            self._fail(f"thread {name!r}", failure.exc_type, failure.exc_value)
        self._hooks[0](failure)

    def _call_failed(self, failure: sys.UnraisableHookArgs) -> None:
        """Stop the robot if a thread started by the module ``_thread`` fails; ignore other failures."""
        if "thread" in (failure.err_msg or ""):
            self._fail("a thread", failure.exc_type, failure.exc_value)
        self._hooks[2](failure)

    def _fail(self, who: str, kind: type[BaseException], value: BaseException | None) -> None:
        reason = f"{who} failed: {kind.__name__}: {value}"
        self._end(reason, RobotError(f"{reason}; the robot was stopped"))

    def _program_failed(self, kind: type[BaseException], *rest: Any) -> None:
        self._end(f"the program failed: {kind.__name__}", None)
        self._hooks[1](kind, *rest)


def _forget() -> None:
    """Forget the watch in a forked child, which has handlers but no thread.

    The signals of the child are not for the parent.
    """
    global _current
    if _current is not None:
        _current = None
        signal.set_wakeup_fd(-1)


if sys.platform != "win32":
    os.register_at_fork(after_in_child=_forget)
