"""The reports of the emulated P3-DX, sent every cycle."""

from collections.abc import Sequence
from typing import Final

from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.encoder_packet import WheelTravel
from hardware.arcos.model import P3DX_SH, SONAR_REACH
from hardware.arcos.packet import encode_packet
from hardware.arcos.sip import Sip, flags
from hardware.emulator.motor_controller import MotorController
from hardware.emulator.plant import Plant
from slam.pose import Pose2D, wrap_angle

FULL_BATTERY: Final = 12.6
"""Volts."""


class P3dxReports:
    """Makes reports from the plant; commands set the origin of its odometry, and the contents of a report."""

    def __init__(self, plant: Plant, config: ArcosConfig) -> None:
        self._plant = plant
        self._config = config
        self._origin = plant.odometry
        self.encoders = False
        self.sonar = True
        self.battery = FULL_BATTERY
        self.outputs = 0
        """Outputs of the digital port, a bit each."""

    @property
    def pose(self) -> Pose2D:
        """Pose of the base by its odometry, from its origin."""
        return self._origin.between(self._plant.odometry)

    def set_origin(self) -> None:
        """Let the odometry begin here: SETO."""
        self._origin = self._plant.odometry

    def packets(self, motors: MotorController) -> bytes:
        """Make a SIP, and an ENCODERpac where it was asked for."""
        report = encode_packet(self._sip(motors).encode(P3DX_SH))
        if self.encoders:
            report += encode_packet(WheelTravel(*self._plant.travel).encode(self._config.ticks_per_metre))
        return report

    def _sip(self, motors: MotorController) -> Sip:
        pose, stalled = self.pose, int(self._plant.stalled)
        left, right = motors.setpoint.to_wheels(2.0 * P3DX_SH.half_track)
        pressed, front = self._plant.bumpers(), self._config.front_bumpers
        ring = self._plant.sonar() if self.sonar else ()
        return Sip(
            moving=motors.moving,
            x=pose.x,
            y=pose.y,
            theta=wrap_angle(pose.theta),
            left=left,
            right=right,
            battery=self.battery,
            left_contacts=stalled | _mask(pressed[front:]) << 1,
            right_contacts=stalled | _mask(pressed[:front]) << 1,
            flags=flags(motors.enabled, motors.e_stop),
            sonar=tuple((number, min(metres, SONAR_REACH)) for number, metres in enumerate(ring)),
            digital_out=self.outputs,
            fine_battery=self.battery,
            charge_state=0,
            turning=motors.angular.speed,
            faults=0,
        )


def _mask(pressed: Sequence[bool]) -> int:
    """Return a bit for each segment, the first in bit 0."""
    return sum(1 << bit for bit, down in enumerate(pressed) if down)
