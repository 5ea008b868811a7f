"""The two devices of a robot, opened and closed together, and the guard that stops it."""

import logging
import threading
import time
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Final

from hardware.lidars.models import lidar_driver
from hardware.p3dx import P3dx
from hardware.staleness_guard import StalenessGuard
from hardware.usb_serial import latency_timer
from hardware.wire.session import WireSession
from slam.odometry import Odometry
from slam.robot import Observation
from slam.scan import LaserScan
from slam.scenario.schema import Scenario

_LOG: Final = logging.getLogger("hopslam.robot")
_LOST_SCANS: Final = 3.0
"""A scan counts as too old only after this many scan periods, so that a slow lidar may lose one."""


@cache
def _warn_of_latency(port: str) -> None:
    """Warn once that the adapter of a port delays bytes."""
    timer = latency_timer(port)
    if timer is not None and timer.advice:
        _LOG.warning("%s: %s", port, timer.advice)


class RobotDevices:
    """Base and lidar of a scenario, opened by the constructor; RobotError names the one that does not answer.

    Once ``leaving`` is set, nothing waits for a device any more. ``record_wire`` receives every byte of both ports.
    """

    def __init__(self, scenario: Scenario, leaving: threading.Event, record_wire: Path | None = None) -> None:
        self._config = scenario.hardware
        self._leaving = leaving
        self.commanded_at = 0.0
        """Time of the newest command, seconds of ``time.monotonic``."""
        for port in (self._config.lidar_port, self._config.robot_port):
            _warn_of_latency(port)
        with ExitStack() as opened:
            wire = opened.enter_context(WireSession(record_wire))
            self.lidar = lidar_driver(scenario.lidar.model)(self._config, scenario.lidar.description, leaving, wire)
            opened.callback(self.lidar.close)
            self.base = P3dx(self._config, scenario.robot.limits, leaving, wire)
            opened.callback(self.base.close)
            self.guard = StalenessGuard(self._ages, self.base.halt)
            opened.callback(self.guard.close)
            self._opened = opened.pop_all()

    def close(self) -> None:
        """Stop the robot, switch the laser off, and free both ports."""
        self.base.halt()
        self._leaving.set()
        self._opened.close()

    @property
    def trouble(self) -> str | None:
        """Reason why the robot stands still although it is commanded to move, or has no data; None if all is well."""
        return self.base.manual_stop or self.base.trouble or self.lidar.trouble or self.guard.reason

    def observation(self, scan: LaserScan, odometry: Odometry) -> Observation:
        """Combine a scan, its odometry, and the latest state of the base."""
        base, bumpers = self.base, self.base.bumpers
        return Observation(
            scan,
            odometry,
            collided=any(bumpers),
            stalled=base.sip.stalled,
            bumpers=bumpers,
            sonar=base.sonar,
            battery=base.battery,
            fault_flags=base.sip.faults or 0,
        )

    @property
    def limits(self) -> dict[str, float]:
        """Ages, seconds, above which a command, a scan and odometry are too old to drive on."""
        config = self._config
        scan = max(config.data_timeout, _LOST_SCANS * self.lidar.period)
        return {"command": config.command_timeout, "scan": scan, "odometry": config.data_timeout}

    def _ages(self) -> dict[str, tuple[float, float]]:
        since = {
            "command": self.commanded_at,
            "scan": self.lidar.scans.scanned_at,
            "odometry": self.base.reported_at,
        }
        now, limits = time.monotonic(), self.limits
        return {name: (now - at, limits[name]) for name, at in since.items()}
