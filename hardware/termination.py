"""SIGTERM as an exception, so that leaving the program stops the robot."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import NoReturn


class Termination:
    """Between ``install`` and ``remove``, SIGTERM raises SystemExit, unless the program has a handler of its own."""

    def __init__(self) -> None:
        self._installed = False

    def install(self) -> None:
        """Only the main thread may, and only where the default would end the process on the spot."""
        main = threading.current_thread() is threading.main_thread()
        if main and signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, _leave)
            self._installed = True

    def remove(self) -> None:
        """As it was before; doing so twice is allowed."""
        if self._installed and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            self._installed = False


def _leave(number: int, _: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)
