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

from hardware.operator_consent import OperatorConsent
from hardware.p3dx import P3dx
from hardware.process_watch import StopCallbacks, process_watch
from hardware.serial_port import SerialPort
from hardware.staleness_guard import StalenessGuard
from hardware.urg04lx import Urg04lx
from hardware.wire.session import WireSession
from slam.closing import Closing
from slam.errors import RobotError, RobotTimeout, ScenarioError
from slam.odometry import Odometry, Twist2D
from slam.robot import Observation, Robot
from slam.scan import LaserScan
from slam.scenario.schema import Scenario

_LOG: Final = logging.getLogger("hopslam.robot")
_ANY_BAUD: Final = 9600
"""Bit rate at which a port is opened to see that it can be; nothing is sent."""


class HardwareRobot(Closing):
    """A P3-DX with a URG-04LX, at the ports that the scenario names; use it as a context manager.

    It ends after the scenario's duration. It moves once somebody has agreed on the terminal, or at once with ``yes``;
    with ``dry_run`` never. It stops when the block is left for whatever reason, when commands, scans or odometry stay
    away, when the program is told to end, is suspended, fails in any thread or loses its terminal, and by its own
    watchdog when this process is killed. Stamps are seconds since the first scan's beginning. Up to four scans wait for
    a caller that observes less often than they come; it gets the oldest of them, or with ``newest`` the last.
    Making one opens and closes both ports, so that a wrong one is refused before anything else is done: PortLost.
    ``record_wire`` is a file that gets every byte of both ports, with times.
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
        if scenario.lidar.model != "urg04lx":
            raise ScenarioError(f"lidar.model: {scenario.lidar.model} is only simulated; set lidar.model=urg04lx")
        self.T_base_laser = scenario.lidar.mount.pose
        self._scenario = scenario
        self._config = scenario.hardware
        self._dry_run = dry_run
        self._newest = newest
        self._record_wire = record_wire
        self._consent = OperatorConsent(yes)
        self._devices: ExitStack | None = None
        self.epoch: float | None = None
        """Time of stamp 0 on the host's monotonic clock, seconds; None before the first scan."""
        self._commanded_at = 0.0
        self._motion = threading.Lock()
        self._over = False
        self._failure: RobotError | None = None
        for port in (self._config.robot_port, self._config.lidar_port):
            SerialPort(port, _ANY_BAUD).close()

    def __enter__(self) -> Self:
        """Open both devices; RobotError names the one that does not answer."""
        with ExitStack() as devices:
            wire = devices.enter_context(WireSession(self._record_wire))
            self._lidar = Urg04lx(self._config, self._scenario.lidar.description.lidar.range_max, wire)
            devices.callback(self._lidar.close)
            self._base = P3dx(self._config, self._scenario.robot.limits, wire)
            devices.callback(self._base.close)
            self._guard = StalenessGuard(self._ages, self._base.halt)
            devices.callback(self._guard.close)
            self._over, self._failure = False, None
            self._reclaim_signals = devices.enter_context(process_watch(StopCallbacks(self._end, self._suspend)))
            self._consent.revoke_after_suspension()
            self._devices = devices.pop_all()
        atexit.register(self.close)
        return self

    def close(self) -> None:
        """Stop the robot, switch the laser off, and free both ports; closing twice is allowed."""
        devices, self._devices = self._devices, None
        if devices is not None:
            self._base.halt()
            devices.close()
            atexit.unregister(self.close)

    @property
    def trouble(self) -> str | None:
        """Reason why the robot stands although it is told to drive, or has no data; None when all is well."""
        return self._base.manual_stop or self._base.trouble or self._lidar.trouble or self._guard.reason

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Wait for the next scan; None when the scenario's duration is over.

        The odometry is that of the first beam, between two reports of the base or carried on from the last one.
        RobotTimeout says why nothing came.
        """
        self._require_open()
        self._base.pulse()
        until = time.monotonic() + timeout
        while (scan := self._lidar.take(max(0.0, until - time.monotonic()), self._newest)) is not None:
            last_beam = scan.stamp + (len(scan.ranges) - 1) * scan.time_increment
            odometry = self._base.odometry(scan.stamp, last_beam, until)
            if odometry is not None:
                return self._observation(scan, odometry)
        raise RobotTimeout(f"no scan with odometry for {timeout:g} s: {self.trouble or 'the lidar is silent'}")

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return the one sent: zero in a dry run, and while anything makes driving unsafe."""
        self._require_open()
        if not (isfinite(command.linear) and isfinite(command.angular)):
            raise RobotError(f"cannot drive at {command}: both speeds must be finite numbers")
        if self._dry_run or self._over:
            return Twist2D()
        if command == Twist2D():
            self._guard.moving = False
            return self._base.drive(command)
        self._reclaim_signals()
        if not self._consent.given:
            self._guard.moving = False
            self._base.drive(Twist2D())
            self._consent.ask(lambda: self._over)
        with self._motion:
            if self._over or not self._consent.given:
                return Twist2D()
            self._commanded_at = time.monotonic()
            return self._base.drive(command) if self._may_move() else Twist2D()

    def _end(self, reason: str, error: RobotError | None) -> None:
        """Stop, and stand until the robot is opened anew; ``error`` is raised by whoever uses it until then."""
        with self._motion:
            self._guard.stop(reason)
            self._over, self._failure = True, self._failure or error

    def _suspend(self, reason: str) -> None:
        """Stop, and stand until somebody has agreed again, ``yes`` or not."""
        with self._motion:
            self._guard.stop(reason)
            self._consent.revoke()

    def _may_move(self) -> bool:
        """Stop the robot and return False where anything is wrong; else give the motors power and return True."""
        by_hand = self._base.manual_stop
        reason = by_hand or self._guard.stale_input()
        if by_hand:
            self._consent.withdraw()
        if reason is not None:
            self._guard.stop(reason)
            return False
        if not self._base.sip.motors_enabled:
            self._base.arm()
        self._guard.moving, self._guard.reason = True, None
        return True

    def _ages(self) -> dict[str, tuple[float, float]]:
        config, now = self._config, time.monotonic()
        return {
            "command": (now - self._commanded_at, config.command_timeout),
            "scan": (now - self._lidar.scanned_at, config.data_timeout),
            "odometry": (now - self._base.reported_at, config.data_timeout),
        }

    def _observation(self, scan: LaserScan, odometry: Odometry) -> Observation | None:
        if self.epoch is None:
            self.epoch = scan.stamp
            _LOG.info("stamp 0 is %.6f s of the host's monotonic clock", self.epoch)
        stamp = scan.stamp - self.epoch
        if stamp > self._scenario.duration - scan.scan_time / 2.0:
            return None
        bumpers = self._base.bumpers
        return Observation(
            replace(scan, stamp=stamp),
            replace(odometry, stamp=stamp),
            collided=any(bumpers),
            stalled=self._base.sip.stalled,
            bumpers=bumpers,
            sonar=self._base.sonar,
        )

    def _require_open(self) -> None:
        if self._failure is not None:
            raise self._failure
        if self._devices is None:
            raise RobotError("the robot is closed; use it as a context manager: with HardwareRobot(scenario) as robot")


_: type[Robot] = HardwareRobot
