"""Signals that end or suspend a program."""

import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import Final

_HANG_UP: Final = getattr(signal, "SIGHUP", None)


_suspensions = 0


@contextmanager
def signal_handler(handler: Callable[[int, FrameType | None], object], numbers: Iterable[int]) -> Iterator[None]:
    """Handle these signals while the block runs; only possible in the main thread.

    SIGHUP stays ignored in a program that was started with nohup.
    """
    with ExitStack() as before:
        if threading.current_thread() is threading.main_thread():
            for number in numbers:
                if number != _HANG_UP or signal.getsignal(number) is not signal.SIG_IGN:
                    before.callback(signal.signal, number, signal.signal(number, handler))
        yield


def count_suspensions() -> int:
    """Count the suspensions since the first call, which must come from the main thread; Windows has none."""
    if sys.platform == "win32":
        return 0
    if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGCONT) is signal.SIG_DFL:
        signal.signal(signal.SIGCONT, _count_suspension)
    return _suspensions


def _count_suspension(_number: int, _: FrameType | None) -> None:
    global _suspensions
    _suspensions += 1
