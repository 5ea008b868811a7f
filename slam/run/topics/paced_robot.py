"""A robot slowed down to real time: a simulated one, or a recorded log."""

from collections.abc import Callable
from time import monotonic, sleep
from typing import Final

from slam.robot import Observation, Robot
from slam.run.topics.wrapped_robot import WrappedRobot

_TICK: Final = 0.01
"""Seconds between two calls of ``tick``."""
_FARTHEST_BEHIND: Final = 0.2
"""Largest delay of the robot, seconds, that it makes up for."""


class PacedRobot(WrappedRobot):
    """Returns each scan when its time has come on the wall clock; ``pace`` is the robot's time per wall time.

    While it waits, ``tick`` gets the time of the robot, seconds, 100 times a second.
    """

    def __init__(self, robot: Robot, pace: float, tick: Callable[[float], None]) -> None:
        super().__init__(robot)
        self._pace, self._tick = pace, tick
        self._stamp: float | None = None
        self._due = 0.0

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Return the next scan when its time has come."""
        seen = self._robot.observe(timeout)
        if seen is not None:
            self._wait_for(seen.scan.stamp)
        return seen

    def _wait_for(self, stamp: float) -> None:
        now = monotonic()
        due = now if self._stamp is None else self._due + (stamp - self._stamp) / self._pace
        self._stamp, self._due = stamp, max(due, now - _FARTHEST_BEHIND)
        while (left := self._due - monotonic()) > 0.0:
            self._tick(stamp - left * self._pace)
            sleep(min(left, _TICK))
