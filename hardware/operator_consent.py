"""The operator's consent: asks on the terminal whether the robot may move."""

import sys
from collections.abc import Callable
from typing import ClassVar, Final

from hardware.keyboard import forget_typed, typed_line
from slam.console.signals import count_suspensions
from slam.errors import RobotError

_QUESTION: Final = "The robot is about to move. Is its path clear, and a hand at the emergency stop? [y/N] "


class OperatorConsent:
    """Consent to motion, given once for a run.

    It is asked again after somebody stopped the robot or suspended the program.
    """

    _known_suspensions: ClassVar[int] = 0

    def __init__(self, given: bool) -> None:
        self._always = self.given = given
        self._cure = "give --yes, or yes=True, when its path is clear"
        count_suspensions()  # from now on

    def ask(self, over: Callable[[], bool]) -> None:
        """Wait for an answer; none is needed once the program is ``over``.

        RobotError if consent is refused, or if there is no terminal to ask on.
        """
        if not sys.stdin.isatty():
            raise RobotError(f"the robot would move, and nobody can be asked here; {self._cure}")
        forget_typed()  # input from before the question does not count
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
        """Require a new answer, as somebody stopped the robot, unless ``yes`` was given."""
        self.given = self._always

    def revoke(self) -> None:
        """Require a new answer in any case, as the program was suspended for an unknown time."""
        self._always = self.given = False
        self._cure = "the program was suspended: start it again"

    def revoke_after_suspension(self) -> None:
        """Revoke consent if the program was suspended since the last call."""
        if count_suspensions() > OperatorConsent._known_suspensions:
            self.revoke()
        OperatorConsent._known_suspensions = count_suspensions()
