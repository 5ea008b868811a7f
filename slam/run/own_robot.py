"""A user's own back end, checked at every call."""

from typing import Any, Self

from slam.errors import RobotError
from slam.named_code import call, find_code
from slam.odometry import Odometry, Twist2D
from slam.own_checks import expect, expect_parts
from slam.pose import Pose2D
from slam.robot import Observation, Restartable, Robot
from slam.scan import LaserScan


class OwnRobot:
    """Calls the user's robot, and checks its results.

    InputError if it cannot be made or is not a robot; RobotError, with its name, if it raises, or returns something
    that Robot does not allow.
    """

    def __init__(self, place: str, *arguments: Any, **more: Any) -> None:
        self._place = place
        self._robot = call(place, find_code(place, (place,)), *arguments, **more)
        expect_parts(place, self._robot, ("T_base_laser", "__enter__", "__exit__", "observe", "drive"), "robot")
        self.T_base_laser: Pose2D = self._robot.T_base_laser

    def __enter__(self) -> Self:
        self._call("__enter__")
        return self

    def __exit__(self, *error: object) -> None:
        self._call("__exit__", *error)

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """See Robot."""
        observation: Observation | None = self._call("observe", timeout)
        if observation is not None:
            self._expect("observe", observation, Observation)
            self._expect("observe: Observation.scan", observation.scan, LaserScan)
            self._expect("observe: Observation.odometry", observation.odometry, Odometry)
        return observation

    def drive(self, command: Twist2D) -> Twist2D:
        """See Robot."""
        applied: Twist2D = self._call("drive", command)
        self._expect("drive", applied, Twist2D)
        return applied

    def _call(self, name: str, *arguments: Any) -> Any:
        return call(f"{self._place}.{name}", getattr(self._robot, name), *arguments, raises=RobotError)

    def _expect(self, name: str, value: Any, kind: type) -> None:
        expect(f"{self._place}.{name}", value, kind, RobotError)


class RestartableOwnRobot(OwnRobot):
    """An OwnRobot that can be reset to its start."""

    def restart(self, seed: int) -> None:
        """See Restartable."""
        self._call("restart", seed)


_: type[Robot] = OwnRobot
__: type[Restartable] = RestartableOwnRobot
