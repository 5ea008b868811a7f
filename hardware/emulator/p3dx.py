"""The P3-DX of the emulator: ARCOS on one side, a plant on the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Final

from hardware.arcos.commands import BAUDS, Command, CommandId, decode_vel2
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.encoder_packet import WheelTravel
from hardware.arcos.identity import Identity
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.arcos.sip import Sip, flags
from hardware.arcos.units import P3DX_SH, SONAR_REACH
from hardware.damaged import Damaged
from hardware.emulator.motion import FACTORY, Motion
from hardware.emulator.plant import Plant
from slam.pose import wrap_angle

_TICK: Final = 0.01
"""Seconds between two turns of the firmware's loop."""
_SILENCE: Final = 0.1
"""Seconds between two bytes after which they belong to different packets."""
_SYNC0, _SYNC1, _SYNC2 = 0, 1, 2
_IDENTITY: Final = Identity("emulated", "Pioneer", "p3dx-sh")
_BATTERY: Final = 12.6


class EmulatedP3dx:
    """Moves its plant and talks of it. Also kept open, and at its bit rate, when a client dies."""

    def __init__(self, plant: Plant, now: float = 0.0, config: ArcosConfig = FACTORY) -> None:
        self._plant = plant
        self._config = config
        self.due = now + _TICK
        self._sip_at = now + config.sip_cycle
        self._decoder = PacketDecoder()
        self._heard_at = now
        self._origin = plant.odometry
        self._synced = 0
        self._encoders = False
        self._commands = self._make_commands()
        self.open = False
        self.baud = BAUDS[config.host_baud]
        self.motion = Motion(config)

    @property
    def wake(self) -> float:
        """The next report."""
        return self._sip_at

    @property
    def moved_until(self) -> float:
        """The time up to which its plant has moved."""
        return self.due - _TICK

    @property
    def damaged(self) -> int:
        """Packets that came in damaged."""
        return self._decoder.damaged

    def step(self) -> bytes:
        """One turn of the firmware's loop: motors, then a report every cycle."""
        now = self.due
        self.due += _TICK
        self.motion.advance(_TICK, now)
        self._plant.advance(_TICK, self.motion.setpoint)
        if now < self._sip_at - _TICK / 2.0:
            return b""
        self._sip_at += self._config.sip_cycle
        return self._report() if self.open else b""

    def receive(self, data: bytes, now: float) -> bytes:
        """Obey; some commands are answered at once."""
        if now - self._heard_at > _SILENCE:
            self._decoder.flush()
        self._heard_at = now
        answers = b""
        for packet in self._decoder.feed(data):
            with suppress(Damaged):
                command = Command.decode(packet)
                answers += self._obey(command, now) if self.open else self._handshake(command, packet, now)
        return answers

    def _handshake(self, command: Command, packet: bytes, now: float) -> bytes:
        """SYNC0, SYNC1 and SYNC2 in this order, then OPEN, which has the number of SYNC1."""
        if command.id == CommandId.OPEN and self._synced == _SYNC2 + 1:
            self._open(now)
            return b""
        if command.id not in (_SYNC0, _SYNC1, _SYNC2):
            return b""
        self._synced = command.id + 1
        return encode_packet(_IDENTITY.encode() if command.id == _SYNC2 else packet)

    def _open(self, now: float) -> None:
        self.open, self._encoders = True, False
        self.motion = Motion(self._config)
        self.motion.feed(now)

    def _close(self) -> None:
        self.open, self._synced = False, 0
        self.motion.enable(False)
        self.baud = BAUDS[self._config.host_baud]

    def _obey(self, command: Command, now: float) -> bytes:
        self.motion.feed(now)
        if command.id == CommandId.CONFIG:
            return encode_packet(self._config.encode())
        act = self._commands.get(command.id)
        if act is not None:
            act(command)
        return b""

    def _make_commands(self) -> dict[int, Callable[[Command], object]]:
        return {
            CommandId.CLOSE: lambda _: self._close(),
            CommandId.ENABLE: lambda command: self.motion.enable(command.argument != 0),
            CommandId.VEL: lambda command: self.motion.ask(linear=command.quantity),
            CommandId.RVEL: lambda command: self.motion.ask(angular=command.quantity),
            CommandId.VEL2: self._vel2,
            CommandId.STOP: lambda _: self.motion.ask(0.0, 0.0),
            CommandId.E_STOP: lambda _: self.motion.stop_hard(),
            CommandId.E_STALL: lambda _: self.motion.stop_hard(),
            CommandId.SETO: lambda _: self._set_origin(),
            CommandId.SETV: self._set_speed,
            CommandId.SETRV: self._set_speed,
            CommandId.SETA: self._set_ramp,
            CommandId.SETRA: self._set_ramp,
            CommandId.ENCODER: self._set_encoders,
            CommandId.HOSTBAUD: self._set_baud,
        }

    def _vel2(self, command: Command) -> None:
        if isinstance(command.argument, int):
            left, right = decode_vel2(command.argument)
            self.motion.ask((left + right) / 2.0, (right - left) / 2.0 / P3DX_SH.half_track)

    def _set_origin(self) -> None:
        self._origin = self._plant.odometry

    def _set_speed(self, command: Command) -> None:
        ramp, top = (
            (self.motion.linear, self._config.top_linear)
            if command.id == CommandId.SETV
            else (self.motion.angular, self._config.top_angular)
        )
        ramp.limit = min(abs(command.quantity), top)

    def _set_ramp(self, command: Command) -> None:
        ramp = self.motion.linear if command.id == CommandId.SETA else self.motion.angular
        if command.quantity > 0.0:
            ramp.rise = command.quantity
        elif command.quantity < 0.0:
            ramp.fall = -command.quantity

    def _set_encoders(self, command: Command) -> None:
        self._encoders = bool(command.argument)

    def _set_baud(self, command: Command) -> None:
        if isinstance(command.argument, int) and 0 <= command.argument < len(BAUDS):
            self.baud = BAUDS[command.argument]

    def _report(self) -> bytes:
        report = encode_packet(self._sip().encode(P3DX_SH))
        if self._encoders:
            report += encode_packet(WheelTravel(*self._plant.travel).encode(self._config.ticks_per_metre))
        return report

    def _contacts(self) -> tuple[int, int]:
        """The contact bits of the left side, with the rear bumpers, and of the right side, with the front ones."""
        pressed, front = self._plant.bumpers(), self._config.front_bumpers
        stalled = int(self._plant.stalled)
        return stalled | _mask(pressed[front:]) << 1, stalled | _mask(pressed[:front]) << 1

    def _echoes(self) -> tuple[tuple[int, float], ...]:
        return tuple((number, min(metres, SONAR_REACH)) for number, metres in enumerate(self._plant.sonar()))

    def _sip(self) -> Sip:
        pose, motion = self._origin.between(self._plant.odometry), self.motion
        rim = motion.angular.speed * P3DX_SH.half_track
        left_contacts, right_contacts = self._contacts()
        return Sip(
            moving=motion.moving,
            x=pose.x,
            y=pose.y,
            theta=wrap_angle(pose.theta),
            left=motion.linear.speed - rim,
            right=motion.linear.speed + rim,
            battery=_BATTERY,
            left_contacts=left_contacts,
            right_contacts=right_contacts,
            flags=flags(motion.enabled, motion.e_stop),
            sonar=self._echoes(),
            fine_battery=_BATTERY,
            charge_state=0,
            turning=motion.angular.speed,
            faults=0,
        )


def _mask(pressed: Sequence[bool]) -> int:
    """A bit for each segment, the first in bit 0."""
    return sum(1 << bit for bit, down in enumerate(pressed) if down)
