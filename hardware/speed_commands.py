"""Velocities as commands of an ARCOS robot, whose speeds have whole steps."""

from abc import ABC, abstractmethod

from hardware.arcos.commands import SI_PER_UNIT, VEL2_UNIT, Command, CommandId, encode_vel2
from slam.odometry import Twist2D
from slam.scenario.robot_config import Limits


class SpeedCommands(ABC):
    """Turns a velocity into two speeds, each in whole steps, and these into commands.

    The rounding error of one command is added to the next, so that the mean is right: in steps of 1 deg/s a turn of 0.3
    deg/s becomes 1 deg/s in every third command, instead of none at all.
    """

    step: tuple[float, float]
    """Step of each speed, SI units."""

    def __init__(self, limits: Limits, half_track: float) -> None:
        self._limits = limits
        self._half_track = half_track
        self._remainder = (0.0, 0.0)

    def commands_for(self, twist: Twist2D) -> tuple[list[Command], Twist2D]:
        """Return the commands for this velocity, clipped to the limits, and the velocity that they command."""
        if twist == Twist2D():
            self._remainder = (0.0, 0.0)
        wanted = [a + b for a, b in zip(self._speeds(self._within_limits(twist)), self._remainder, strict=True)]
        first, second = (round(speed / step) * step for speed, step in zip(wanted, self.step, strict=True))
        self._remainder = wanted[0] - first, wanted[1] - second
        return self._commands(first, second), self._twist(first, second)

    def _within_limits(self, twist: Twist2D) -> Twist2D:
        v, w = self._limits.linear, self._limits.angular
        return Twist2D(max(-v, min(v, twist.linear)), max(-w, min(w, twist.angular)))

    @abstractmethod
    def _speeds(self, twist: Twist2D) -> tuple[float, float]: ...
    @abstractmethod
    def _commands(self, first: float, second: float) -> list[Command]: ...
    @abstractmethod
    def _twist(self, first: float, second: float) -> Twist2D: ...


class BaseSpeeds(SpeedCommands):
    """Commands VEL and RVEL: the base's speeds, in steps of 1 mm/s and 1 deg/s."""

    step = SI_PER_UNIT[CommandId.VEL], SI_PER_UNIT[CommandId.RVEL]

    def _speeds(self, twist: Twist2D) -> tuple[float, float]:
        return twist.linear, twist.angular

    def _commands(self, first: float, second: float) -> list[Command]:
        return [Command.of(CommandId.VEL, first), Command.of(CommandId.RVEL, second)]

    def _twist(self, first: float, second: float) -> Twist2D:
        return Twist2D(first, second)


class WheelSpeeds(SpeedCommands):
    """Command VEL2: the speeds of the left and the right wheel, in steps of 20 mm/s."""

    step = VEL2_UNIT, VEL2_UNIT

    def _speeds(self, twist: Twist2D) -> tuple[float, float]:
        return twist.to_wheels(2.0 * self._half_track)

    def _commands(self, first: float, second: float) -> list[Command]:
        return [encode_vel2(first, second)]

    def _twist(self, first: float, second: float) -> Twist2D:
        return Twist2D.from_wheels(first, second, 2.0 * self._half_track)
