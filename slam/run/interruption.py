"""Ctrl-C and SIGTERM, between two steps."""

from __future__ import annotations

import signal
import threading
from contextlib import ExitStack
from types import FrameType
from typing import Self

from slam.run.loop import Step


class Interruption:
    """A watcher that ends the run after the step in which the user asked for it, so that no step is half done.

    Raised anywhere else, a KeyboardInterrupt may come up inside compiled code, which makes a SystemError of it. Asked
    again, it ends the run at once.
    """

    def __init__(self) -> None:
        self._asked = False
        self._handlers = ExitStack()

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():  # no other may handle signals
            for number in (signal.SIGINT, signal.SIGTERM):
                self._handlers.callback(signal.signal, number, signal.signal(number, self._ask))
        return self

    def __exit__(self, *_: object) -> None:
        self._handlers.close()

    def see(self, step: Step) -> None:
        """Raise KeyboardInterrupt when it was asked for."""
        if self._asked:
            raise KeyboardInterrupt

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True
