"""The commands of an open, emulated P3-DX, and their actions on its motors and reports."""

from collections.abc import Callable
from typing import Final

from hardware.arcos.commands import Command, CommandId, decode_vel2
from hardware.arcos.model import P3DX_SH
from hardware.emulator.motor_controller import MotorController
from hardware.emulator.p3dx_reports import P3dxReports
from slam.odometry import Twist2D
from slam.pose import wrap_angle


def execute(command: Command, motors: MotorController, reports: P3dxReports) -> None:
    """Carry out a command; unknown ones are ignored. DecodeError where the argument is missing."""
    action = _ACTIONS.get(command.id)
    if action is not None:
        action(command, motors, reports)


def _set_wheel_speeds(command: Command, motors: MotorController, _: P3dxReports) -> None:
    twist = Twist2D.from_wheels(*decode_vel2(_number(command)), 2.0 * P3DX_SH.half_track)
    motors.set_targets(twist.linear, twist.angular)


def _turn_to(command: Command, motors: MotorController, reports: P3dxReports) -> None:
    motors.turn_by(wrap_angle(command.quantity - reports.pose.theta))


def _report_encoders(command: Command, _: MotorController, reports: P3dxReports) -> None:
    reports.encoders = bool(command.argument)


def _report_sonar(command: Command, _: MotorController, reports: P3dxReports) -> None:
    reports.sonar = bool(command.argument)


def _set_outputs(command: Command, _: MotorController, reports: P3dxReports) -> None:
    """Carry out DIGOUT: the high byte has the bits to change, the low byte their new values."""
    mask, bits = divmod(_number(command) & 0xFFFF, 0x100)
    reports.outputs = reports.outputs & ~mask | bits & mask


def _number(command: Command) -> int:
    return command.argument if isinstance(command.argument, int) else 0


_ACTIONS: Final[dict[int, Callable[[Command, MotorController, P3dxReports], None]]] = {
    CommandId.ENABLE: lambda command, motors, _: motors.enable(command.argument != 0),
    CommandId.VEL: lambda command, motors, _: motors.set_targets(linear=command.quantity),
    CommandId.RVEL: lambda command, motors, _: motors.set_targets(angular=command.quantity),
    CommandId.ROTATE: lambda command, motors, _: motors.set_targets(angular=command.quantity),
    CommandId.VEL2: _set_wheel_speeds,
    CommandId.MOVE: lambda command, motors, _: motors.move_by(command.quantity),
    CommandId.HEAD: _turn_to,
    CommandId.DHEAD: lambda command, motors, _: motors.turn_by(command.quantity),
    CommandId.STOP: lambda _, motors, __: motors.set_targets(0.0, 0.0),
    CommandId.E_STOP: lambda _, motors, __: motors.stop_hard(),
    CommandId.E_STALL: lambda _, motors, __: motors.stop_hard(),
    CommandId.SETO: lambda _, __, reports: reports.set_origin(),
    CommandId.SETV: lambda command, motors, _: motors.linear.set_limit(command.quantity),
    CommandId.SETRV: lambda command, motors, _: motors.angular.set_limit(command.quantity),
    CommandId.SETA: lambda command, motors, _: motors.linear.set_slope(command.quantity),
    CommandId.SETRA: lambda command, motors, _: motors.angular.set_slope(command.quantity),
    CommandId.ENCODER: _report_encoders,
    CommandId.SONAR: _report_sonar,
    CommandId.DIGOUT: _set_outputs,
}
