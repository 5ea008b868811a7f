"""Keyboard of the operator: input typed on the terminal."""

import sys
from collections.abc import Callable
from time import sleep
from typing import Final

_LOOK: Final = 0.1
"""Seconds between two calls of ``over``."""


def forget_typed() -> None:
    """Discard everything typed before this call."""
    if sys.platform == "win32":
        import msvcrt

        while msvcrt.kbhit():
            msvcrt.getwch()
    else:
        import termios

        termios.tcflush(sys.stdin, termios.TCIFLUSH)


def typed_line(over: Callable[[], bool]) -> str:
    """Return the next line typed; an empty string once ``over`` returns True."""
    if sys.platform == "win32":  # select works with sockets only
        import msvcrt

        line = ""
        while not line.endswith("\r") and not over():
            if msvcrt.kbhit():
                line += msvcrt.getwche()
            else:
                sleep(_LOOK)
        return line
    import select

    while not over():
        if select.select([sys.stdin], [], [], _LOOK)[0]:
            return sys.stdin.readline()
    return ""
