"""The Pioneer P3-DX on its serial line."""

import logging
import threading
import time
from contextlib import suppress
from math import inf
from typing import Final

from hardware import DecodeError
from hardware.arcos.commands import Command, CommandId
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.encoder_packet import ENCODER_PACKET, WheelTravel
from hardware.arcos.model import SONAR_REACH
from hardware.arcos.sip import Sip, is_sip
from hardware.arcos_line import ArcosLine, ReceivedPacket
from hardware.arcos_session import disconnect_robot
from hardware.base_odometry import EncoderOdometry, PositionOdometry, WheelScales, sip_twist
from hardware.battery_watch import BatteryWatch
from hardware.device_thread import DeviceThread
from hardware.odometry_history import OdometryHistory
from hardware.p3dx_setup import OpenedP3dx, open_p3dx
from hardware.serial_port import PortLost
from hardware.speed_commands import BaseSpeeds, SpeedCommands, WheelSpeeds
from hardware.wire.session import WireSession
from slam.odometry import Odometry, Twist2D
from slam.robot import Battery
from slam.scenario.hardware_config import HardwareConfig
from slam.scenario.robot_config import Limits
from slam.sonar_ring import FRONT

_LOG: Final = logging.getLogger("hopslam.p3dx")
_POLL: Final = 0.1
"""Seconds after which the thread checks whether it should end."""
_ODOMETRY_WAIT: Final = 0.02
"""Seconds between two checks for odometry that is late."""
_SPEEDS: Final[dict[str, type[SpeedCommands]]] = {"velocity": BaseSpeeds, "wheels": WheelSpeeds}


class P3dx:
    """Opened by the constructor: the robot is found, its settings are read, and it reports from then on.

    Its motors have no power. A thread reads the reports, and opens the port again when it is lost. ``drive``, ``halt``
    and ``pulse`` may be called from any thread. Once ``leaving`` is set, attempts to connect are given up. RobotError
    if no robot answers, or its watchdog is off.
    """

    def __init__(self, config: HardwareConfig, limits: Limits, leaving: threading.Event, wire: WireSession) -> None:
        self._config = config
        self._wire = wire
        self._limits = limits
        self._lock = threading.RLock()
        self._leaving = leaving
        self._closed = False
        self._history = OdometryHistory()
        self._settings = ArcosConfig()
        self.sip = Sip()
        self._echoes: dict[int, float] = {}
        self.reported_at = self._sent_at = time.monotonic()
        self._position: PositionOdometry | None = None
        self._line = self._connect()
        self.reported_at = time.monotonic()
        self._thread = DeviceThread("robot", self._serve, self._lose, self._reconnect, leaving)
        self._thread.start()

    @property
    def trouble(self) -> str | None:
        """Reason why no reports arrive; None if they do."""
        return self._thread.trouble

    @property
    def bumpers(self) -> tuple[bool, ...]:
        """True for each segment that is pressed: front, then rear."""
        sip, settings = self.sip, self._settings
        return _bits(sip.front_bumpers, settings.front_bumpers) + _bits(sip.rear_bumpers, settings.rear_bumpers)

    @property
    def sonar(self) -> tuple[float, ...]:
        """Sonar ranges in the order of transducer number, padded to complete rings; metres, inf without an echo."""
        rings = -(-(max(self._echoes, default=-1) + 1) // FRONT)
        echoes = (self._echoes.get(number, inf) for number in range(rings * FRONT))
        return tuple(echo if echo < SONAR_REACH else inf for echo in echoes)

    @property
    def battery(self) -> Battery | None:
        """State of the battery from the reports of the last seconds; None if they do not contain it."""
        return self._battery.state

    @property
    def manual_stop(self) -> str | None:
        """Reason why the robot cannot move until somebody intervenes; None if it can."""
        if self.sip.e_stop:
            return "the emergency stop is pressed; release it, and the run goes on"
        if self._was_armed and not self.sip.motors_enabled:
            return "the motors were switched off; press the robot's motor button, and the run goes on"
        return None

    def arm(self) -> None:
        """Give the motors power."""
        self._send(Command(CommandId.ENABLE, 1))

    def drive(self, twist: Twist2D) -> Twist2D:
        """Send a velocity within the limits, rounded to the units of the wire, and return the one that was sent."""
        with self._lock:
            commands, sent = self._speeds.commands_for(twist)
            self._send(*commands)
        return sent

    def halt(self) -> None:
        """Stop with the largest deceleration, and forget the commanded velocity."""
        self._send(Command(CommandId.E_STOP), Command(CommandId.VEL, 0), Command(CommandId.RVEL, 0))

    def pulse(self) -> None:
        """Tell the watchdog that this program is alive, if no command did for a quarter of the watchdog time."""
        if time.monotonic() - self._sent_at > self._settings.watchdog / 4.0:
            self._send(Command(CommandId.PULSE))

    def odometry(self, first: float, last: float, until: float) -> Odometry | None:
        """Return the odometry at ``first``, with the mean speed to ``last``.

        Waits until ``until`` for reports that cover both times; None without them. Times are those of
        ``time.monotonic``.
        """
        while True:
            with self._lock:
                if self._history.covers(first) and self._history.covers(last):
                    return self._history.between(first, last)
                known = self._history.last
            if known is None or known[0] > max(first, last) or time.monotonic() >= until or self._leaving.is_set():
                return None
            time.sleep(_ODOMETRY_WAIT)

    def close(self) -> None:
        """Stop, take the power from the motors, and close the port; closing twice is allowed."""
        if self._closed:
            return
        self._closed = True
        self._leaving.set()
        with self._lock, suppress(PortLost):
            disconnect_robot(self._line)
        self._thread.close()
        self._line.port.close()

    def _send(self, *commands: Command) -> None:
        """Send commands; PortLost is left to the thread, which meets it too and reports it in ``trouble``."""
        with self._lock, suppress(PortLost):
            for command in commands:
                self._line.send(command)
            self._sent_at = time.monotonic()

    def _connect(self) -> ArcosLine:
        opened = open_p3dx(self._config, self._limits, self._leaving, self._wire)
        config, half_track = self._config, opened.units.half_track
        scales = WheelScales(half_track, config.left_scale, config.right_scale, config.track_scale)
        by_encoders = config.odometry == "encoders"
        with self._lock:
            self._catch_up(opened)
            self._was_armed = False
            self._speeds = _SPEEDS[config.drive_by](self._limits, half_track)
            self._units, self._settings = opened.units, opened.settings
            self._battery = BatteryWatch(self._config, opened.settings)
            self._position = PositionOdometry(opened.units, scales, OdometryHistory() if by_encoders else self._history)
            ticks = opened.settings.ticks_per_metre
            self._encoders = EncoderOdometry(ticks, scales, self._history) if by_encoders else None
        return opened.line

    def _catch_up(self, opened: OpenedP3dx) -> None:
        """Add the distance that the robot rolled while its cable was unplugged, unless it was switched off."""
        report = opened.line.report_when_found_open
        if self._position is not None and report is not None:
            with suppress(DecodeError):
                self._position.add(report.stamp, Sip.decode(report.data, opened.units))

    def _serve(self) -> None:
        for arrival in self._line.receive(_POLL):
            self._take(arrival)

    def _take(self, arrival: ReceivedPacket) -> None:
        """Process one packet; one that cannot be decoded, although its checksum is correct, is dropped."""
        with suppress(DecodeError), self._lock:
            if is_sip(arrival.data):
                self._take_sip(arrival.stamp, Sip.decode(arrival.data, self._units))
            elif arrival.data[0] == ENCODER_PACKET and self._encoders is not None:
                travel = WheelTravel.decode(arrival.data, self._settings.ticks_per_metre)
                self._encoders.add(arrival.stamp, travel, sip_twist(self.sip, self._units))

    def _take_sip(self, stamp: float, sip: Sip) -> None:
        if self._position is not None and self._position.add(stamp, sip):
            self.sip, self.reported_at, self._thread.trouble = sip, stamp, None
            self._echoes = self._echoes | dict(sip.sonar)
            self._battery.take(stamp, sip.volts)
            self._was_armed = (self._was_armed or sip.motors_enabled) and not sip.e_stop

    def _lose(self) -> None:
        """Stop the robot if its line still works, and release the line."""
        self.halt()
        _LOG.warning("%s: until the robot is found again, only its own watchdog stops it", self._line.port.url)
        self._line.port.close()

    def _reconnect(self) -> None:
        line = self._connect()
        with self._lock:
            self._line = line


def _bits(mask: int, count: int) -> tuple[bool, ...]:
    return tuple(bool(mask >> bit & 1) for bit in range(count))
