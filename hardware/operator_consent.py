"""The operator's consent: asks on the terminal whether the robot may move."""

import sys
from collections.abc import Callable
from typing import ClassVar, Final

from hardware.keyboard import forget_typed, typed_line
from slam.console.signals import count_suspensions
from slam.errors import RobotError

_QUESTION: Final = "The robot is about to move. Is its way free, and a hand at the emergency stop? [y/N] "


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
        forget_typed()  # an answer is typed after its question
        print(_QUESTION, end="", flush=True)
        answer = typed_line(over).strip().lower()
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
