"""The reports of the emulated P3-DX, sent every cycle."""

from collections.abc import Sequence
from math import inf
from typing import Final

from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.encoder_packet import WheelTravel
from hardware.arcos.io_packet import IoReport
from hardware.arcos.model import P3DX_SH, SONAR_REACH
from hardware.arcos.packet import encode_packet
from hardware.arcos.sip import Sip, flags
from hardware.emulator.aux_port import SERAUX_PACKETS, AuxPort
from hardware.emulator.motor_controller import MotorController
from hardware.emulator.plant import Plant
from slam.pose import Pose2D, wrap_angle

FULL_BATTERY: Final = 12.6
"""Volts."""
SONAR_ARRAYS: Final = 4
_ARRAY_SIZE: Final = 8
_NOT_TOUCHED: Final = 0xFF
_ANALOG_PORTS: Final = 8
_VOLTS_PER_COUNT: Final = 20.0 / 1023
"""Scale of the battery at its analogue port: our choice, as the manual does not state it."""


class Request:
    """Packets of one kind that were asked for: none, one, or one in every cycle."""

    def __init__(self) -> None:
        self._left = 0.0

    def ask(self, argument: int) -> None:
        """Request one packet (1), one in every cycle (more), or no more packets (0)."""
        self._left = inf if argument > 1 else max(argument, 0)

    def take(self) -> bool:
        """Return True if a packet is due in this cycle, and count it."""
        due = self._left > 0
        self._left -= due
        return due


class P3dxReports:
    """Makes the robot's reports from the state of the plant; commands set the odometry's origin and request packets."""

    def __init__(self, plant: Plant, config: ArcosConfig) -> None:
        self._plant = plant
        self._config = config
        self._origin = plant.odometry
        self.battery = FULL_BATTERY
        self.aux = [AuxPort(packet_id) for packet_id in SERAUX_PACKETS]
        self.reset()

    def reset(self) -> None:
        """Forget what clients have asked for."""
        self.encoders, self.io = Request(), Request()
        self.outputs = 0
        """Outputs of the digital port, a bit each."""
        self.analog_port = 0
        self.enable_sonar(True)

    def enable_sonar(self, on: bool, array: int | None = None) -> None:
        """Switch one sonar array, counted from 1, or all fitted ones."""
        fitted = {1} | ({2} if self._config.rear_sonar else set())
        if array is None:
            self.sonar_arrays = fitted if on else set[int]()
        elif array in fitted:
            self.sonar_arrays = self.sonar_arrays | {array} if on else self.sonar_arrays - {array}

    @property
    def pose(self) -> Pose2D:
        """Odometry pose of the base relative to the origin that SETO has set."""
        return self._origin.between(self._plant.odometry)

    def set_origin(self) -> None:
        """Make the present pose the origin of the odometry: SETO."""
        self._origin = self._plant.odometry

    def packets(self, motors: MotorController) -> bytes:
        """Make a SIP, followed by the packets that were requested."""
        pressed = self._plant.bumpers()
        report = encode_packet(self._sip(motors, pressed).encode(P3DX_SH))
        if self.encoders.take():
            report += encode_packet(WheelTravel(*self._plant.travel).encode(self._config.ticks_per_metre))
        if self.io.take():
            report += encode_packet(self._io(pressed).encode())
        return report + b"".join(port.packet() for port in self.aux)

    def _sip(self, motors: MotorController, pressed: Sequence[bool]) -> Sip:
        pose, stalled = self.pose, int(self._plant.stalled)
        left, right = motors.setpoint.to_wheels(2.0 * P3DX_SH.half_track)
        front = self._config.front_bumpers
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
            flags=flags(motors.enabled, motors.e_stop, self.sonar_arrays),
            sonar=tuple(self._echoes()),
            analog_port=self.analog_port,
            digital_out=self.outputs,
            fine_battery=self.battery,
            charge_state=0,
            turning=motors.angular.speed,
            faults=0,
        )

    def _echoes(self) -> list[tuple[int, float]]:
        """Return the number and reading, metres, of each transducer of the arrays that are on."""
        ring = enumerate(self._plant.sonar() if self.sonar_arrays else ())
        return [(n, min(metres, SONAR_REACH)) for n, metres in ring if n // _ARRAY_SIZE + 1 in self.sonar_arrays]

    def _io(self, pressed: Sequence[bool]) -> IoReport:
        front = self._config.front_bumpers
        battery = round(self.battery / _VOLTS_PER_COUNT)
        return IoReport(
            digital_in=0,
            front_bumpers=_NOT_TOUCHED & ~_mask(pressed[:front]),
            rear_bumpers=_NOT_TOUCHED & ~_mask(pressed[front:]),
            infrared=_NOT_TOUCHED,
            digital_out=self.outputs,
            analog=(0,) * _ANALOG_PORTS + (min(battery, 1023),),
        )


def _mask(pressed: Sequence[bool]) -> int:
    """Return a bit for each segment, the first in bit 0."""
    return sum(1 << bit for bit, down in enumerate(pressed) if down)
