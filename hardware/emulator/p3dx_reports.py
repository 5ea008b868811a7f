"""What the emulated P3-DX says of itself every cycle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.encoder_packet import WheelTravel
from hardware.arcos.packet import encode_packet
from hardware.arcos.sip import Sip, flags
from hardware.arcos.units import P3DX_SH, SONAR_REACH
from hardware.emulator.motion import Motion
from hardware.emulator.plant import Plant
from slam.pose import Pose2D, wrap_angle

_BATTERY: Final = 12.6


class P3dxReports:
    """Reads the plant; commands say where its odometry begins, and what is in a report."""

    def __init__(self, plant: Plant, config: ArcosConfig) -> None:
        self._plant = plant
        self._config = config
        self._origin = plant.odometry
        self.encoders = False
        self.sonar = True
        self.outputs = 0
        """Of the digital port, a bit each."""

    @property
    def pose(self) -> Pose2D:
        """Where the base is by its odometry, from where that began."""
        return self._origin.between(self._plant.odometry)

    def begin_here(self) -> None:
        """SETO."""
        self._origin = self._plant.odometry

    def packets(self, motion: Motion) -> bytes:
        """A SIP, and the encoders where they were asked for."""
        report = encode_packet(self._sip(motion).encode(P3DX_SH))
        if self.encoders:
            report += encode_packet(WheelTravel(*self._plant.travel).encode(self._config.ticks_per_metre))
        return report

    def _contacts(self) -> tuple[int, int]:
        """The contact bits of the left side, with the rear bumpers, and of the right side, with the front ones."""
        pressed, front = self._plant.bumpers(), self._config.front_bumpers
        stalled = int(self._plant.stalled)
        return stalled | _mask(pressed[front:]) << 1, stalled | _mask(pressed[:front]) << 1

    def _echoes(self) -> tuple[tuple[int, float], ...]:
        ring = self._plant.sonar() if self.sonar else ()
        return tuple((number, min(metres, SONAR_REACH)) for number, metres in enumerate(ring))

    def _sip(self, motion: Motion) -> Sip:
        pose = self.pose
        left, right = motion.setpoint.wheels(2.0 * P3DX_SH.half_track)
        left_contacts, right_contacts = self._contacts()
        return Sip(
            moving=motion.moving,
            x=pose.x,
            y=pose.y,
            theta=wrap_angle(pose.theta),
            left=left,
            right=right,
            battery=_BATTERY,
            left_contacts=left_contacts,
            right_contacts=right_contacts,
            flags=flags(motion.enabled, motion.e_stop),
            sonar=self._echoes(),
            digital_out=self.outputs,
            fine_battery=_BATTERY,
            charge_state=0,
            turning=motion.angular.speed,
            faults=0,
        )


def _mask(pressed: Sequence[bool]) -> int:
    """A bit for each segment, the first in bit 0."""
    return sum(1 << bit for bit, down in enumerate(pressed) if down)
