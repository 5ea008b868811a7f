"""The operator's consent: asks on the terminal whether the robot may move."""

import select
import sys
import termios
from collections.abc import Callable
from typing import ClassVar, Final

from slam.console.signals import count_suspensions
from slam.errors import RobotError

_QUESTION: Final = "The robot is about to move. Is its way free, and a hand at the emergency stop? [y/N] "
_LOOK: Final = 0.1
"""Seconds between two checks whether the program must end."""


class OperatorConsent:
    """Given once for a run, and asked for again after somebody stopped the robot by hand, or suspended the program."""

    _known_suspensions: ClassVar[int] = 0

    def __init__(self, given: bool) -> None:
        self._always = self.given = given
        self._cure = "give --yes, or yes=True, when its way is free"
        count_suspensions()  # from now on

    def ask(self, over: Callable[[], bool]) -> None:
        """Wait for an answer; once the program is ``over`` none is needed.

        RobotError where it is refused, or where there is no terminal to ask on.
        """
        if not sys.stdin.isatty():
            raise RobotError(f"the robot would move, and nobody can be asked here; {self._cure}")
        termios.tcflush(sys.stdin, termios.TCIFLUSH)  # an answer is typed after its question
        print(_QUESTION, end="", flush=True)
        answer = _read_line(over).strip().lower()
        if over():
            return
        if answer not in ("y", "yes"):
            raise RobotError(
                "the robot was not allowed to move; give --dry-run, or dry_run=True, to look without moving"
            )
        self.given = True

    def withdraw(self) -> None:
        """Ask again, as somebody stopped the robot, unless consent was given for all cases."""
        self.given = self._always

    def revoke(self) -> None:
        """Ask again in any case, as the program was suspended, and nobody knows for how long."""
        self._always = self.given = False
        self._cure = "the program was suspended: start it again"

    def revoke_after_suspension(self) -> None:
        """Revoke consent where the program was suspended since a robot of it last called this, or since it began."""
        if count_suspensions() > OperatorConsent._known_suspensions:
            self.revoke()
        OperatorConsent._known_suspensions = count_suspensions()


def _read_line(over: Callable[[], bool]) -> str:
    while not over():
        if select.select([sys.stdin], [], [], _LOOK)[0]:
            return sys.stdin.readline()
    return ""
