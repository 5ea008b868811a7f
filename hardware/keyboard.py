"""The operator's keyboard: what is typed on the terminal that standard input is."""

import sys
from collections.abc import Callable
from time import sleep
from typing import Final

_LOOK: Final = 0.1
"""Seconds between two checks whether the program must end."""


def forget_typed() -> None:
    """Drop what was typed until now."""
    if sys.platform == "win32":
        import msvcrt

        while msvcrt.kbhit():
            msvcrt.getwch()
    else:
        import termios

        termios.tcflush(sys.stdin, termios.TCIFLUSH)


def typed_line(over: Callable[[], bool]) -> str:
    """Wait for a line; an empty one once the program is ``over``."""
    if sys.platform == "win32":  # where select takes sockets only
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
