"""Waiting for a robot that falls silent."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import TypeVar

from slam.errors import RobotTimeout
from slam.odometry import Twist2D

Taken = TypeVar("Taken")


def step_patiently(step: Callable[[Twist2D], Taken], command: Twist2D, patience: float) -> tuple[Taken, int]:
    """Make a step, which drives until the next scan comes; where no scan comes, stand and wait for one.

    Returns what the step returned, and how often the robot was silent for too long. RobotTimeout after ``patience``
    seconds.
    """
    until, timeouts = monotonic() + patience, 0
    while True:
        try:
            return step(command), timeouts
        except RobotTimeout:
            if monotonic() >= until:
                raise
            command, timeouts = Twist2D(), timeouts + 1
