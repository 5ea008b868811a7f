"""Ctrl-C, and the signals that ask a program to end, between two steps of a run."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import Final, Self

from slam.run.loop import Step

ENDING_SIGNALS: Final = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT") if hasattr(signal, name)
)

_HANG_UP: Final = getattr(signal, "SIGHUP", None)


class Interruption:
    """A watcher that ends the run after the step in which the user asked for it, so that no step is half done.

    Raised anywhere else, a KeyboardInterrupt may come up inside compiled code, which makes a SystemError of it. What
    follows the loop is done to its end, unless Ctrl-C is pressed again. A closed terminal is no reason to end for a
    program that was started with nohup.
    """

    def __init__(self) -> None:
        self.signal: int | None = None
        """Number of the signal that asked first; None while nobody has."""
        self._handlers = ExitStack()

    def __enter__(self) -> Self:
        self._handlers.enter_context(handled(self._ask, ENDING_SIGNALS))
        return self

    def __exit__(self, *_: object) -> None:
        self._handlers.close()

    def see(self, step: Step) -> None:
        """Raise KeyboardInterrupt when it was asked for."""
        if self.signal is not None:
            raise KeyboardInterrupt

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self.signal is None:
            self.signal = number
        elif number == signal.SIGINT:
            raise KeyboardInterrupt


@contextmanager
def handled(handler: Callable[[int, FrameType | None], object], numbers: Iterable[int]) -> Iterator[None]:
    """Handle these signals while the block runs; only the main thread can.

    The signal of a closed terminal is left alone in a program that was started with nohup.
    """
    with ExitStack() as before:
        if threading.current_thread() is threading.main_thread():
            for number in numbers:
                if number != _HANG_UP or signal.getsignal(number) is not signal.SIG_IGN:
                    before.callback(signal.signal, number, signal.signal(number, handler))
        yield
