"""Ctrl-C, and the other signals that ask a program to end, between two steps of a run."""

from __future__ import annotations

from contextlib import ExitStack
from signal import SIGINT
from types import FrameType
from typing import Self

from slam.console.ending_signals import ENDING_SIGNALS, handled
from slam.run.step import Step


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
        elif number == SIGINT:
            raise KeyboardInterrupt
