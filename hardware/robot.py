"""The real robot behind the ``Robot`` protocol."""

import atexit
import logging
import threading
import time
from contextlib import ExitStack
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Final, Self

from hardware.devices import RobotDevices
from hardware.lidars.models import lidar_driver
from hardware.operator_consent import OperatorConsent
from hardware.process_watch import StopCallbacks, process_watch
from hardware.serial_port import PortLost, SerialPort
from slam.closing import Closing
from slam.errors import BatteryEmpty, RobotError, RobotTimeout
from slam.odometry import Odometry, Twist2D
from slam.robot import Observation, Robot
from slam.scan import LaserScan
from slam.scenario.schema import Scenario

_LOG: Final = logging.getLogger("hopslam.robot")
_LOOK: Final = 0.1
"""Seconds between two checks whether the program was told to end."""
_LAST_WAIT: Final = 0.2
"""Seconds for which the program, told to end, still waits for a scan."""
_LEAST_WAIT: Final = 2.0
"""Least scan periods for which ``observe`` waits."""
_ANY_BAUD: Final = 9600
"""Bit rate at which a port is opened to test it; nothing is sent."""


class HardwareRobot(Closing):
    """A P3-DX with a lidar, at the ports that the scenario names; use it as a context manager.

    The run ends after the scenario's duration. The robot moves once somebody has agreed on the terminal, or at once
    with ``yes``; with ``dry_run`` never. It stops when the block is left for whatever reason, when commands, scans or
    odometry stay away, when the program is told to end, is suspended, fails in any thread or loses its terminal, and by
    its own watchdog when this process is killed. Stamps are seconds since the first scan's beginning. Up to four scans
    wait for a caller that observes less often than they arrive; it gets the oldest of them, or with ``newest`` the
    last. The constructor opens and closes both ports, so that a wrong port is refused at once: PortLost.
    ``record_wire`` is a file for every byte of both ports, with times.
    """

    def __init__(
        self,
        scenario: Scenario,
        seed: int | None = None,
        yes: bool = False,
        dry_run: bool = False,
        newest: bool = False,
        record_wire: Path | None = None,
    ) -> None:
        lidar_driver(scenario.lidar.model)  # a model that has no driver is refused here
        self.T_base_laser = scenario.lidar.mount.pose
        self._scenario = scenario
        self._dry_run = dry_run
        self._newest = newest
        self._record_wire = record_wire
        self._consent = OperatorConsent(yes)
        self._devices: RobotDevices | None = None
        self._watch = ExitStack()
        self.epoch: float | None = None
        """Time of stamp 0 on the host's monotonic clock, seconds; None before the first scan."""
        self._motion = threading.Lock()
        self._leaving = threading.Event()
        self._over: str | None = None
        """Reason why the program ends; None while it runs."""
        self._failure: RobotError | None = None
        for port in (scenario.hardware.lidar_port, scenario.hardware.robot_port):
            SerialPort(port, _ANY_BAUD).close()

    def __enter__(self) -> Self:
        """Open both devices.

        RobotError names the one that does not answer, or says that the program was told to end.
        """
        self._leaving, self._over, self._failure = threading.Event(), None, None
        with ExitStack() as watch:
            self._reclaim_signals = watch.enter_context(process_watch(StopCallbacks(self._end, self._suspend)))
            try:
                self._devices = RobotDevices(self._scenario, self._leaving, self._record_wire)
            except PortLost as lost:
                raise self._ended() or lost from lost
            self._watch = watch.pop_all()
        self._consent.revoke_after_suspension()
        atexit.register(self.close)
        return self

    def close(self) -> None:
        """Stop the robot, switch the laser off, and free both ports; closing twice is allowed."""
        devices, self._devices = self._devices, None
        if devices is not None:
            with self._watch:
                devices.close()
            atexit.unregister(self.close)

    @property
    def trouble(self) -> str | None:
        """Reason why the robot stands still although it is commanded to move, or has no data; None if all is well."""
        return self._devices.trouble if self._devices else None

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Wait for the next scan, at least two scan periods; None once the scenario's duration is over.

        The odometry is that of the first beam, interpolated between two reports of the base or predicted from the last
        one. RobotTimeout says why no scan came. BatteryEmpty means that the robot has stopped for good. Once the
        program was told to end, RobotError says so, without waiting.
        """
        devices = self._opened()
        devices.base.pulse()
        until = time.monotonic() + max(timeout, _LEAST_WAIT * devices.lidar.period)
        while (scan := self._next_scan(devices, until)) is not None:
            last_beam = scan.stamp + (len(scan.ranges) - 1) * scan.time_increment
            odometry = devices.base.odometry(scan.stamp, last_beam, until)
            if odometry is not None:
                self._require_battery(devices)
                return self._observation(devices, scan, odometry)
        if (ended := self._ended()) is not None:
            raise ended
        raise RobotTimeout(f"no scan with odometry for {timeout:g} s: {devices.trouble or 'the lidar is silent'}")

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return the one sent: zero in a dry run, and while driving is unsafe."""
        devices = self._opened()
        if not (isfinite(command.linear) and isfinite(command.angular)):
            raise RobotError(f"cannot drive at {command}: both speeds must be finite numbers")
        if self._dry_run or self._over:
            return Twist2D()
        if command == Twist2D():
            devices.guard.moving = False
            return devices.base.drive(command)
        self._reclaim_signals()
        if not self._consent.given:
            devices.guard.moving = False
            devices.base.drive(Twist2D())
            self._consent.ask(lambda: self._over is not None)
        with self._motion:
            if self._over or not self._consent.given:
                return Twist2D()
            devices.commanded_at = time.monotonic()
            return devices.base.drive(command) if self._may_move(devices) else Twist2D()

    def _next_scan(self, devices: RobotDevices, until: float) -> LaserScan | None:
        """Wait for a scan until ``until``, but only briefly once the program was told to end."""
        while True:
            left = max(0.0, until - time.monotonic())
            if self._over is not None:
                return devices.lidar.scans.take(min(left, _LAST_WAIT), self._newest)
            scan = devices.lidar.scans.take(min(left, _LOOK), self._newest)
            if scan is not None or left <= _LOOK:
                return scan

    def _ended(self) -> RobotError | None:
        """Return the error of a robot whose program was told to end; None while it runs."""
        return self._failure or (RobotError(f"given up: {self._over}") if self._over is not None else None)

    def _end(self, reason: str, error: RobotError | None) -> None:
        """Stop, and stay at rest until the robot is opened again; until then every call raises ``error``."""
        self._leaving.set()
        with self._motion:
            if self._devices is not None:
                self._devices.guard.stop(reason)
            self._over, self._failure = self._over or reason, self._failure or error

    def _suspend(self, reason: str) -> None:
        """Stop, and stay at rest until somebody has agreed again, even with ``yes``."""
        with self._motion:
            if self._devices is not None:
                self._devices.guard.stop(reason)
            self._consent.revoke()

    def _may_move(self, devices: RobotDevices) -> bool:
        """Stop the robot and return False if anything is wrong; otherwise power the motors and return True."""
        base, guard = devices.base, devices.guard
        by_hand = base.manual_stop
        reason = by_hand or guard.stale_input()
        if by_hand:
            self._consent.withdraw()
        if reason is not None:
            guard.stop(reason)
            return False
        if not base.sip.motors_enabled:
            base.arm()
        guard.moving, guard.reason = True, None
        return True

    def _observation(self, devices: RobotDevices, scan: LaserScan, odometry: Odometry) -> Observation | None:
        if self.epoch is None:
            self.epoch = scan.stamp
            _LOG.info("stamp 0 is %.6f s of the host's monotonic clock", self.epoch)
        stamp = scan.stamp - self.epoch
        if stamp > self._scenario.duration - scan.scan_time / 2.0:
            return None
        return devices.observation(replace(scan, stamp=stamp), replace(odometry, stamp=stamp))

    def _require_battery(self, devices: RobotDevices) -> None:
        """Stop for good if the battery is empty, and raise BatteryEmpty."""
        battery = devices.base.battery
        if battery is not None and battery.level == "empty":
            reason = f"the battery is down to {battery.volts:.1f} V"
            devices.guard.stop(reason)
            self._failure = BatteryEmpty(f"{reason}, so the robot was stopped; charge it (hardware.end_battery)")
            raise self._failure

    def _opened(self) -> RobotDevices:
        if self._failure is not None:
            raise self._failure
        if self._devices is None:
            raise RobotError("the robot is closed; use it as a context manager: with HardwareRobot(scenario) as robot")
        return self._devices


_: type[Robot] = HardwareRobot
