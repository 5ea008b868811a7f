"""A simulated robot whose time passes only with commands, scan by scan."""

from typing import Final

from slam.errors import RobotTimeout
from slam.odometry import Twist2D
from slam.robot import Robot
from slam.run.topics.velocity_commands import VelocityCommands
from slam.run.topics.wrapped_robot import WrappedRobot

_LOOK: Final = 0.5
"""Seconds between two checks whether the run was told to end."""


class SteppedRobot(WrappedRobot):
    """Waits after each scan for a command, and drives by that until the next scan.

    The commands then depend on the scans alone, however slow either program is.
    """

    def __init__(self, robot: Robot, commands: VelocityCommands) -> None:
        super().__init__(robot)
        self._commands, self._taken = commands, 0

    def drive(self, command: Twist2D) -> Twist2D:
        """Drive by the next command from outside; RobotTimeout if none has come yet."""
        if not self._commands.wait_for_more(self._taken, _LOOK):
            raise RobotTimeout("no command on /cmd_vel yet, and the run is stepped (--pace 0)")
        self._taken, command = self._commands.last
        return self._robot.drive(command)
