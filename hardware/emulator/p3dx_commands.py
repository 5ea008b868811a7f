"""The actions of an open, emulated P3-DX upon each command."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from hardware.arcos.commands import Command, CommandId, decode_vel2
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.model import P3DX_SH
from hardware.emulator.motor_controller import MotorController
from hardware.emulator.p3dx_reports import P3dxReports
from slam.pose import wrap_angle


class P3dxCommands:
    """Carries out a client's commands on a robot's motors and reports; unknown ones are ignored."""

    def __init__(self, config: ArcosConfig, motors: MotorController, reports: P3dxReports) -> None:
        self._config = config
        self._motors = motors
        self._reports = reports

    def execute(self, command: Command) -> None:
        """Carry out a command; DecodeError where its argument is missing."""
        action = _ACTIONS.get(command.id)
        if action is not None:
            action(self, command)

    def _enable(self, command: Command) -> None:
        self._motors.enable(command.argument != 0)

    def _velocity(self, command: Command) -> None:
        self._motors.set_targets(linear=command.quantity)

    def _turning(self, command: Command) -> None:
        self._motors.set_targets(angular=command.quantity)

    def _wheel_speeds(self, command: Command) -> None:
        left, right = decode_vel2(_number(command))
        self._motors.set_targets((left + right) / 2.0, (right - left) / 2.0 / P3DX_SH.half_track)

    def _move(self, command: Command) -> None:
        self._motors.move_by(command.quantity)

    def _turn_by(self, command: Command) -> None:
        self._motors.turn_by(command.quantity)

    def _turn_to(self, command: Command) -> None:
        self._motors.turn_by(wrap_angle(command.quantity - self._reports.pose.theta))

    def _stop(self, _: Command) -> None:
        self._motors.set_targets(0.0, 0.0)

    def _stop_hard(self, _: Command) -> None:
        self._motors.stop_hard()

    def _set_origin(self, _: Command) -> None:
        self._reports.set_origin()

    def _limit_speed(self, command: Command) -> None:
        self._motors.linear.limit = min(abs(command.quantity), self._config.top_linear)

    def _limit_turning(self, command: Command) -> None:
        self._motors.angular.limit = min(abs(command.quantity), self._config.top_angular)

    def _set_slope(self, command: Command) -> None:
        self._motors.linear.set_slope(command.quantity)

    def _set_turning_slope(self, command: Command) -> None:
        self._motors.angular.set_slope(command.quantity)

    def _report_encoders(self, command: Command) -> None:
        self._reports.encoders = bool(command.argument)

    def _report_sonar(self, command: Command) -> None:
        self._reports.sonar = bool(command.argument)

    def _set_outputs(self, command: Command) -> None:
        """Carry out DIGOUT: the high byte has the bits to change, the low byte their new values."""
        mask, bits = divmod(_number(command) & 0xFFFF, 0x100)
        self._reports.outputs = self._reports.outputs & ~mask | bits & mask


def _number(command: Command) -> int:
    """Return the argument; 0 where there is none."""
    return command.argument if isinstance(command.argument, int) else 0


_ACTIONS: Final[dict[int, Callable[[P3dxCommands, Command], None]]] = {
    CommandId.ENABLE: P3dxCommands._enable,
    CommandId.VEL: P3dxCommands._velocity,
    CommandId.RVEL: P3dxCommands._turning,
    CommandId.ROTATE: P3dxCommands._turning,
    CommandId.VEL2: P3dxCommands._wheel_speeds,
    CommandId.MOVE: P3dxCommands._move,
    CommandId.HEAD: P3dxCommands._turn_to,
    CommandId.DHEAD: P3dxCommands._turn_by,
    CommandId.STOP: P3dxCommands._stop,
    CommandId.E_STOP: P3dxCommands._stop_hard,
    CommandId.E_STALL: P3dxCommands._stop_hard,
    CommandId.SETO: P3dxCommands._set_origin,
    CommandId.SETV: P3dxCommands._limit_speed,
    CommandId.SETRV: P3dxCommands._limit_turning,
    CommandId.SETA: P3dxCommands._set_slope,
    CommandId.SETRA: P3dxCommands._set_turning_slope,
    CommandId.ENCODER: P3dxCommands._report_encoders,
    CommandId.SONAR: P3dxCommands._report_sonar,
    CommandId.DIGOUT: P3dxCommands._set_outputs,
}
