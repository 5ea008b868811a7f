"""Asking whether the robot may move."""

from __future__ import annotations

import sys

from slam.errors import RobotError

_QUESTION = "The robot is about to move. Is its way free, and a hand at the emergency stop? [y/N] "


class Consent:
    """Given once for a run, and asked for again after somebody stopped the robot by hand.

    RobotError where it is refused, or where there is no terminal to ask on.
    """

    def __init__(self, given: bool) -> None:
        self._always = self._given = given

    def require(self) -> None:
        """Ask unless it was given."""
        if self._given:
            return
        if not sys.stdin.isatty():
            raise RobotError(
                "the robot would move, and nobody can be asked here; give --yes, or yes=True, when its way is free"
            )
        print(_QUESTION, end="", flush=True)
        if sys.stdin.readline().strip().lower() not in ("y", "yes"):
            raise RobotError(
                "the robot was not allowed to move; give --dry-run, or dry_run=True, to look without moving"
            )
        self._given = True

    def withdraw(self) -> None:
        """Somebody stopped the robot: ask again, unless it was given for all cases."""
        self._given = self._always
