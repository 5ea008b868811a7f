"""Signals that end or suspend a program, passed on before they take effect."""

import logging
import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from types import FrameType
from typing import Any, Final, NoReturn

from slam.system import ENDING_SIGNALS

_DEADLY: Final = (
    "SIGUSR1", "SIGUSR2", "SIGALRM", "SIGVTALRM", "SIGPROF", "SIGIO", "SIGPWR", "SIGXCPU", "SIGSTKFLT", "SIGABRT",
    "SIGTRAP", "SIGSYS",
)  # fmt: skip
"""Signals that, with the real-time ones, end a program that does not handle them; SIGSEGV and the like cannot be
handled."""
_SUSPENDING: Final = ("SIGTSTP", "SIGTTIN", "SIGTTOU")
CONTINUES: Final[int | None] = getattr(signal, "SIGCONT", None)
"""Signal to a program that was suspended; None on Windows, which has no suspending."""

_LOG: Final = logging.getLogger("hopslam.robot")


class StopSignals:
    """Writes the numbers of signals to ``fd`` from ``install`` to ``remove``, even while the main thread is busy.

    A signal that would kill the program raises SystemExit in it instead. A signal that would suspend the program is
    only written; the reader of ``fd`` suspends the program when the robot is at rest. Signals that the program handles
    or ignores are left to it. Only the main thread can install handlers; elsewhere a warning is logged.
    """

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._installed = False
        self._handled: list[int] = []
        self._previous_fd = -1
        self.ending: set[int] = set(ENDING_SIGNALS)
        """Numbers of the signals that end the program."""
        self.suspending = set(_numbers(_SUSPENDING))
        """Numbers of the signals that suspend it."""

    def install(self) -> None:
        """Take over the signals that have no handler; calling it twice is allowed."""
        if self._installed:
            return
        if not _in_main_thread():
            _LOG.warning("opened outside the main thread: no signal stops the robot, only its own watchdog does")
            return
        real_time = range(getattr(signal, "SIGRTMIN", 0), getattr(signal, "SIGRTMAX", -1) + 1)
        deadly = [*_numbers(_DEADLY), *real_time]
        self.ending |= {number for number in deadly if signal.getsignal(number) is signal.SIG_DFL}
        for number in self.ending:
            self._handle(number, _leave)
        for number in (*self.suspending, *filter(None, [CONTINUES])):
            self._handle(number, _go_on)
        self._previous_fd = signal.set_wakeup_fd(self._fd, warn_on_full_buffer=False)
        self._installed = True

    def reclaim(self) -> None:
        """Receive the numbers again if other code, such as an event loop, has redirected them to itself."""
        if self._installed and _in_main_thread():
            other = signal.set_wakeup_fd(self._fd, warn_on_full_buffer=False)
            if other != self._fd:
                self._previous_fd = other

    def remove(self) -> bool:
        """Restore the handlers, and return True, or return False outside the main thread."""
        if self._installed and not _in_main_thread():
            return False
        if self._installed:
            signal.set_wakeup_fd(self._previous_fd)
        self._installed = False
        while self._handled:
            signal.signal(self._handled.pop(), signal.SIG_DFL)
        return True

    def pass_on(self, numbers: bytes) -> None:
        """Pass the numbers on to the previous file descriptor, of an event loop for example."""
        if self._previous_fd != -1:
            with suppress(OSError):  # it is full, or was closed
                os.write(self._previous_fd, numbers)

    def _handle(self, number: int, handler: Callable[[int, FrameType | None], Any]) -> None:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, handler)
            self._handled.append(number)


def suspend() -> None:
    """Suspend this program until somebody sends SIGCONT."""
    if sys.platform != "win32":
        os.kill(os.getpid(), signal.SIGSTOP)


def name_of(number: int) -> str:
    """Return the name of a signal, ``SIGTERM`` for 15; real-time signals have a number only."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _numbers(names: tuple[str, ...]) -> list[int]:
    """Return the signals with these names that this system has."""
    return [int(getattr(signal, name)) for name in names if hasattr(signal, name)]


def _leave(number: int, _: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)


def _go_on(_number: int, _: FrameType | None) -> None:
    """Do nothing: with a handler, the number reaches the file descriptor."""
