"""What an open, emulated P3-DX does upon each command."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from hardware.arcos.commands import Command, CommandId, decode_vel2
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.units import P3DX_SH
from hardware.emulator.motion import Motion
from hardware.emulator.p3dx_reports import P3dxReports
from slam.odometry import Twist2D
from slam.pose import wrap_angle


class P3dxOrders:
    """A robot's motion and reports under the commands of its client; it ignores what it does not know."""

    def __init__(self, config: ArcosConfig, motion: Motion, reports: P3dxReports) -> None:
        self._config = config
        self._motion = motion
        self._reports = reports

    def obey(self, command: Command) -> None:
        """Do it. Damaged where the argument is missing."""
        act = _ACTS.get(command.id)
        if act is not None:
            act(self, command)

    def _enable(self, command: Command) -> None:
        self._motion.enable(command.argument != 0)

    def _velocity(self, command: Command) -> None:
        self._motion.ask(linear=command.quantity)

    def _turning(self, command: Command) -> None:
        self._motion.ask(angular=command.quantity)

    def _wheels(self, command: Command) -> None:
        twist = Twist2D.from_wheels(*decode_vel2(_number(command)), 2.0 * P3DX_SH.half_track)
        self._motion.ask(twist.linear, twist.angular)

    def _move(self, command: Command) -> None:
        self._motion.go(command.quantity)

    def _turn_by(self, command: Command) -> None:
        self._motion.turn(command.quantity)

    def _turn_to(self, command: Command) -> None:
        self._motion.turn(wrap_angle(command.quantity - self._reports.pose.theta))

    def _stop(self, _: Command) -> None:
        self._motion.ask(0.0, 0.0)

    def _stop_hard(self, _: Command) -> None:
        self._motion.stop_hard()

    def _set_origin(self, _: Command) -> None:
        self._reports.begin_here()

    def _limit(self, command: Command) -> None:
        self._motion.linear.limit = min(abs(command.quantity), self._config.top_linear)

    def _limit_turning(self, command: Command) -> None:
        self._motion.angular.limit = min(abs(command.quantity), self._config.top_angular)

    def _accelerate(self, command: Command) -> None:
        self._motion.linear.set_slope(command.quantity)

    def _accelerate_turning(self, command: Command) -> None:
        self._motion.angular.set_slope(command.quantity)

    def _report_encoders(self, command: Command) -> None:
        self._reports.encoders = bool(command.argument)

    def _report_sonar(self, command: Command) -> None:
        self._reports.sonar = bool(command.argument)

    def _set_outputs(self, command: Command) -> None:
        """DIGOUT: the high byte has the bits to change, the low byte what they become."""
        mask, bits = divmod(_number(command) & 0xFFFF, 0x100)
        self._reports.outputs = self._reports.outputs & ~mask | bits & mask


def _number(command: Command) -> int:
    """The argument; 0 where there is none."""
    return command.argument if isinstance(command.argument, int) else 0


_ACTS: Final[dict[int, Callable[[P3dxOrders, Command], None]]] = {
    CommandId.ENABLE: P3dxOrders._enable,
    CommandId.VEL: P3dxOrders._velocity,
    CommandId.RVEL: P3dxOrders._turning,
    CommandId.ROTATE: P3dxOrders._turning,
    CommandId.VEL2: P3dxOrders._wheels,
    CommandId.MOVE: P3dxOrders._move,
    CommandId.HEAD: P3dxOrders._turn_to,
    CommandId.DHEAD: P3dxOrders._turn_by,
    CommandId.STOP: P3dxOrders._stop,
    CommandId.E_STOP: P3dxOrders._stop_hard,
    CommandId.E_STALL: P3dxOrders._stop_hard,
    CommandId.SETO: P3dxOrders._set_origin,
    CommandId.SETV: P3dxOrders._limit,
    CommandId.SETRV: P3dxOrders._limit_turning,
    CommandId.SETA: P3dxOrders._accelerate,
    CommandId.SETRA: P3dxOrders._accelerate_turning,
    CommandId.ENCODER: P3dxOrders._report_encoders,
    CommandId.SONAR: P3dxOrders._report_sonar,
    CommandId.DIGOUT: P3dxOrders._set_outputs,
}
