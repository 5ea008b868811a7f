"""The P3-DX of the emulator: ARCOS on one side, a plant on the other."""

from __future__ import annotations

from contextlib import suppress
from typing import Final

from hardware.arcos.commands import BAUDS, Command, CommandId
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.identity import Identity
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.decode_error import DecodeError
from hardware.emulator.motion import FACTORY, Motion
from hardware.emulator.p3dx_orders import P3dxOrders
from hardware.emulator.p3dx_reports import P3dxReports
from hardware.emulator.plant import Plant

_TICK: Final = 0.01
"""Seconds between two turns of the firmware's loop."""
_SILENCE: Final = 0.1
"""Seconds between two bytes after which they belong to different packets."""
_SYNC0, _SYNC1, _SYNC2 = 0, 1, 2
_IDENTITY: Final = Identity("emulated", "Pioneer", "p3dx-sh")


class EmulatedP3dx:
    """Moves its plant and talks of it. Also kept open, and at its bit rate, when a client dies."""

    def __init__(self, plant: Plant, now: float = 0.0, config: ArcosConfig = FACTORY) -> None:
        self._plant = plant
        self._config = config
        self.due = now + _TICK
        self._sip_at = now + config.sip_cycle
        self._decoder = PacketDecoder()
        self._heard_at = now
        self._synced = 0
        self.open = False
        self.baud = BAUDS[config.host_baud]
        self._reports = P3dxReports(plant, config)
        self._begin_anew()

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
        return self._reports.packets(self.motion) if self.open else b""

    def receive(self, data: bytes, now: float) -> bytes:
        """Obey; some commands are answered at once."""
        if now - self._heard_at > _SILENCE:
            self._decoder.flush()
        self._heard_at = now
        answers = b""
        for packet in self._decoder.feed(data):
            with suppress(DecodeError):
                command = Command.decode(packet)
                answers += self._obey(command, now) if self.open else self._handshake(command, packet, now)
        return answers

    def _handshake(self, command: Command, packet: bytes, now: float) -> bytes:
        """SYNC0, SYNC1 and SYNC2 in this order, then OPEN, which has the number of SYNC1."""
        if command.id == CommandId.OPEN and self._synced == _SYNC2 + 1:
            self.open = True
            self._begin_anew()
            self.motion.feed(now)
            return b""
        if command.id not in (_SYNC0, _SYNC1, _SYNC2):
            return b""
        self._synced = command.id + 1
        return encode_packet(_IDENTITY.encode() if command.id == _SYNC2 else packet)

    def _obey(self, command: Command, now: float) -> bytes:
        self.motion.feed(now)
        if command.id == CommandId.CONFIG:
            return encode_packet(self._config.encode())
        if command.id == CommandId.CLOSE:
            self._close()
        elif command.id == CommandId.HOSTBAUD:
            self._set_baud(command)
        else:
            self._orders.obey(command)
        return b""

    def _begin_anew(self) -> None:
        """As after power-up, with the settings of the FLASH; but the odometry goes on."""
        self.motion = Motion(self._config)
        self._reports.encoders, self._reports.sonar = False, True
        self._orders = P3dxOrders(self._config, self.motion, self._reports)

    def _close(self) -> None:
        self.open, self._synced = False, 0
        self.motion.enable(False)
        self.baud = BAUDS[self._config.host_baud]

    def _set_baud(self, command: Command) -> None:
        if isinstance(command.argument, int) and 0 <= command.argument < len(BAUDS):
            self.baud = BAUDS[command.argument]
