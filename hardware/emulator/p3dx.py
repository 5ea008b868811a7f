"""The emulated P3-DX: ARCOS on one side, a plant on the other."""

from contextlib import suppress
from math import radians
from typing import Final

from hardware import DecodeError
from hardware.arcos.commands import BAUDS, Command, CommandId
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.model import SYNC2, Identity
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.emulator.motor_controller import MotorController
from hardware.emulator.p3dx_commands import execute
from hardware.emulator.p3dx_reports import P3dxReports
from hardware.emulator.plant import Plant

_TICK: Final = 0.01
"""Seconds between two cycles of the firmware's loop."""
_SILENCE: Final = 0.1
"""Seconds between two bytes after which they belong to different packets."""
_IDENTITY: Final = Identity("emulated", "Pioneer", "p3dx-sh")
FACTORY_CONFIG: Final = ArcosConfig(
    robot_type="Pioneer",
    subtype="p3dx-sh",
    serial_number="EMULATED",
    top_angular=radians(500),
    top_linear=2.2,
    top_angular_acceleration=radians(600),
    top_acceleration=4.0,
    pwm_max=500,
    name="emulated",
    sip_cycle=0.1,
    front_sonar=1,
    low_battery=11.5,
    rev_count=16570,
    watchdog=2.0,
    max_angular=radians(300),
    max_linear=1.2,
    angular_acceleration=radians(100),
    angular_deceleration=radians(100),
    acceleration=0.3,
    deceleration=0.6,
    front_bumpers=5,
    rear_bumpers=5,
    autobaud=2,
    ticks_per_metre=128_000,
    firmware="2.9",
)
"""Settings in the FLASH of a P3-DX with an SH controller."""


class EmulatedP3dx:
    """Moves its plant, and reports on it; when a client dies, it stays open and keeps its bit rate."""

    def __init__(self, plant: Plant, now: float = 0.0, config: ArcosConfig = FACTORY_CONFIG) -> None:
        self._plant = plant
        self.config = config
        self.due = now + _TICK
        self._sip_at = now + config.sip_cycle
        self._decoder = PacketDecoder()
        self._heard_at = now
        self._synced = 0
        self.open = False
        self.baud = BAUDS[config.host_baud]
        self.reports = P3dxReports(plant, config)
        self._reset()

    @property
    def wake(self) -> float:
        """Time of the next report."""
        return self._sip_at

    @property
    def moved_until(self) -> float:
        """Time up to which its plant has moved."""
        return self.due - _TICK

    def set_battery(self, volts: float) -> None:
        """Set the voltage of the battery."""
        self.reports.battery = volts

    def step(self) -> bytes:
        """Run one cycle of the firmware's loop: motors, then a report if one is due."""
        now = self.due
        self.due += _TICK
        self.motors.advance(_TICK, now)
        self._plant.advance(_TICK, self.motors.setpoint)
        if now < self._sip_at - _TICK / 2.0:
            return b""
        self._sip_at += self.config.sip_cycle
        return self.reports.packets(self.motors) if self.open else b""

    def receive(self, data: bytes, now: float) -> bytes:
        """Execute the commands in these bytes, and return the answers that come at once."""
        if now - self._heard_at > _SILENCE:
            self._decoder.flush()
        self._heard_at = now
        answers = b""
        for packet in self._decoder.feed(data):
            with suppress(DecodeError):
                command = Command.decode(packet)
                answers += self._execute(command, now) if self.open else self._handshake(command, packet, now)
        return answers

    def _handshake(self, command: Command, packet: bytes, now: float) -> bytes:
        """Answer SYNC0, SYNC1 and SYNC2 in this order, then open at OPEN, whose number equals that of SYNC1.

        A SYNC that was answered may come again; one out of sequence is ignored (Pioneer 3 Operations Manual, p. 28).
        """
        if command.id == CommandId.OPEN and self._synced == SYNC2 + 1:
            pressed = self.motors.e_stop
            self.open = True
            self._reset()
            self.motors.press_e_stop(pressed)
            self.motors.feed_watchdog(now)
            return b""
        if command.id > min(self._synced, SYNC2):
            return b""
        self._synced = command.id + 1
        return encode_packet(_IDENTITY.encode() if command.id == SYNC2 else packet)

    def _execute(self, command: Command, now: float) -> bytes:
        self.motors.feed_watchdog(now)
        return execute(command, self)

    def close(self) -> None:
        """End the connection: motors without power, and the bit rate of the FLASH."""
        self.open, self._synced = False, 0
        self.motors.enable(False)
        self.baud = BAUDS[self.config.host_baud]

    def _reset(self) -> None:
        """Reset everything except the odometry to its state at power-up, with the settings of the FLASH."""
        self.motors = MotorController(self.config)
        self.reports.reset()
