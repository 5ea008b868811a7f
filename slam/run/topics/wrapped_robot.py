"""Base class of a robot that changes the behaviour of another one."""

from typing import Self

from slam.odometry import Twist2D
from slam.robot import Observation, Robot


class WrappedRobot:
    """Passes all calls to another robot."""

    def __init__(self, robot: Robot) -> None:
        self.T_base_laser = robot.T_base_laser
        self._robot = robot

    def __enter__(self) -> Self:
        self._robot.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._robot.__exit__(*error)

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Return the next scan of the robot."""
        return self._robot.observe(timeout)

    def drive(self, command: Twist2D) -> Twist2D:
        """Command the robot."""
        return self._robot.drive(command)


_: type[Robot] = WrappedRobot
