"""The Pioneer P3-DX on its serial line."""

from __future__ import annotations

import logging
import threading
import time
from contextlib import suppress
from typing import Final

from hardware.arcos.commands import Command, CommandId
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.encoder_packet import ENCODER_PACKET, WheelTravel
from hardware.arcos.sip import Sip, is_sip
from hardware.arcos_session import ArcosLine, Arrival, disconnect
from hardware.backoff import Backoff
from hardware.base_odometry import EncoderOdometry, PositionOdometry, sip_twist
from hardware.decode_error import DecodeError
from hardware.odometry_track import OdometryTrack
from hardware.opened_p3dx import OpenedP3dx, open_p3dx
from hardware.serial_port import PortLost
from hardware.speed_commands import BaseSpeeds, SpeedCommands, WheelSpeeds
from hardware.wheel_scales import WheelScales
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.scenario.hardware_config import HardwareConfig
from slam.scenario.robot_config import Limits

_LOG: Final = logging.getLogger("hopslam.p3dx")
_POLL: Final = 0.1
"""Seconds after which the thread looks whether it should end."""
_SPEEDS: Final[dict[str, type[SpeedCommands]]] = {"velocity": BaseSpeeds, "wheels": WheelSpeeds}


class P3dx:
    """Opened when made: the robot is found, asked for its settings, and reports from then on; its motors have no power.

    A thread reads the reports, and opens the port again when it is lost. ``drive``, ``halt`` and ``pulse`` may be
    called from any thread. RobotError when no robot answers, or its watchdog is off.
    """

    def __init__(self, config: HardwareConfig, limits: Limits) -> None:
        self._config = config
        self._limits = limits
        self._lock = threading.RLock()
        self._closing = threading.Event()
        self.track = OdometryTrack()
        self.settings = ArcosConfig()
        self.sip = Sip()
        self.sonar: dict[int, float] = {}
        self.reported_at = self._sent_at = time.monotonic()
        self.trouble: str | None = None
        self._position: PositionOdometry | None = None
        self._line = self._connect()
        self.reported_at = time.monotonic()
        self._thread = threading.Thread(target=self._serve, name="p3dx", daemon=True)
        self._thread.start()

    @property
    def odometry_lock(self) -> threading.RLock:
        """To be held while reading the track."""
        return self._lock

    @property
    def armed(self) -> bool:
        """Whether the motors have power, by the last report."""
        return self.sip.motors_enabled

    @property
    def hindrance(self) -> str | None:
        """What somebody did by hand that keeps the robot from moving; None when nothing."""
        if self.sip.e_stop:
            return "the emergency stop is pressed; release it, and the run goes on"
        if self._was_armed and not self.armed:
            return "the motors were switched off; press the robot's motor button, and the run goes on"
        return None

    def arm(self) -> None:
        """Give the motors power."""
        self._send(Command(CommandId.ENABLE, 1))

    def drive(self, twist: Twist2D) -> Twist2D:
        """Send a velocity within the limits, as near as the wire can say it; the one that was sent."""
        with self._lock:
            commands, sent = self._speeds.say(twist)
            self._send(*commands)
        return sent

    def halt(self) -> None:
        """Stop as hard as the robot can, and forget the velocity."""
        self._send(Command(CommandId.E_STOP), Command(CommandId.VEL, 0), Command(CommandId.RVEL, 0))

    def pulse(self) -> None:
        """Tell the robot's watchdog that this program lives, if nothing else did for a quarter of its time."""
        if time.monotonic() - self._sent_at > self.settings.watchdog / 4.0:
            self._send(Command(CommandId.PULSE))

    def close(self) -> None:
        """Stop, take the power from the motors, and let go of the robot; closing twice is allowed."""
        if self._closing.is_set():
            return
        self._closing.set()
        with self._lock, suppress(PortLost):
            disconnect(self._line)
        self._thread.join()
        self._line.port.close()

    def _send(self, *commands: Command) -> None:
        """PortLost is left to the thread, which finds it too and says so in ``trouble``."""
        with self._lock, suppress(PortLost):
            for command in commands:
                self._line.send(command)
            self._sent_at = time.monotonic()

    def _connect(self) -> ArcosLine:
        opened = open_p3dx(self._config, self._limits, self._closing)
        config, half_track = self._config, opened.units.half_track
        scales = WheelScales(half_track, config.left_scale, config.right_scale, config.track_scale)
        by_encoders = config.odometry == "encoders"
        with self._lock:
            self._catch_up(opened)
            self._was_armed = False
            self._speeds = _SPEEDS[config.drive_by](self._limits, half_track)
            self._units, self.settings = opened.units, opened.settings
            self._position = PositionOdometry(opened.units, scales, OdometryTrack() if by_encoders else self.track)
            ticks = opened.settings.ticks_per_metre
            self._encoders = EncoderOdometry(ticks, scales, self.track) if by_encoders else None
        return opened.line

    def _catch_up(self, opened: OpenedP3dx) -> None:
        """The way that a robot went on while its cable was out; it has counted it unless it was switched off."""
        report = opened.line.left_open
        if self._position is not None and report is not None:
            with suppress(DecodeError):
                self._position.add(report.stamp, Sip.decode(report.data, opened.units))

    def _serve(self) -> None:
        while not self._closing.is_set():
            try:
                for arrival in self._line.receive(_POLL):
                    self._take(arrival)
            except PortLost as lost:
                self._reconnect(str(lost))

    def _take(self, arrival: Arrival) -> None:
        """One packet; what is damaged behind a right checksum is dropped too."""
        with suppress(DecodeError), self._lock:
            if is_sip(arrival.data):
                self._take_sip(arrival.stamp, Sip.decode(arrival.data, self._units))
            elif arrival.data[0] == ENCODER_PACKET and self._encoders is not None:
                travel = WheelTravel.decode(arrival.data, self.settings.ticks_per_metre)
                self._encoders.add(arrival.stamp, travel, sip_twist(self.sip, self._units))

    def _take_sip(self, stamp: float, sip: Sip) -> None:
        if self._position is not None and self._position.add(stamp, sip):
            self.sip, self.reported_at, self.trouble = sip, stamp, None
            self.sonar = self.sonar | dict(sip.sonar)
            self._was_armed = (self._was_armed or sip.motors_enabled) and not sip.e_stop

    def _reconnect(self, reason: str) -> None:
        """Try again and again, and ever less often, until the robot answers or the driver is closed."""
        self.trouble = reason
        _LOG.warning("%s; the robot's own watchdog stops it", reason)
        self._line.port.close()
        for _ in Backoff(self._closing):
            try:
                line = self._connect()
            except RobotError as error:
                self.trouble = str(error)
                continue
            with self._lock:
                self._line = line
            _LOG.warning("%s: the robot is back", line.port.url)
            return
