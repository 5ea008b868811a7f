"""A robot in real time that could be faster: a simulated one, or a recorded log."""

from collections.abc import Callable
from time import monotonic, sleep
from typing import Final, Self

from slam.odometry import Twist2D
from slam.robot import Observation, Robot

_TICK: Final = 0.01
"""Seconds between two times that are told ..."""
_FARTHEST_BEHIND: Final = 0.2
"""... and by which the robot may be late and still make it up."""


class PacedRobot:
    """Gives each scan when its time has come on the wall clock; ``pace`` is how much faster than that time goes.

    While it waits, ``tick`` gets the time of the robot, seconds, 100 times a second.
    """

    def __init__(self, robot: Robot, pace: float, tick: Callable[[float], None]) -> None:
        self.T_base_laser = robot.T_base_laser
        self._robot, self._pace, self._tick = robot, pace, tick
        self._stamp: float | None = None
        self._due = 0.0

    def __enter__(self) -> Self:
        self._robot.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._robot.__exit__(*error)

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """The next scan, when its time has come."""
        seen = self._robot.observe(timeout)
        if seen is not None:
            self._wait_for(seen.scan.stamp)
        return seen

    def drive(self, command: Twist2D) -> Twist2D:
        """Command the robot."""
        return self._robot.drive(command)

    def _wait_for(self, stamp: float) -> None:
        now = monotonic()
        due = now if self._stamp is None else self._due + (stamp - self._stamp) / self._pace
        self._stamp, self._due = stamp, max(due, now - _FARTHEST_BEHIND)
        while (left := self._due - monotonic()) > 0.0:
            self._tick(stamp - left * self._pace)
            sleep(min(left, _TICK))


_: type[Robot] = PacedRobot
