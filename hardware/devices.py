"""The two devices of a robot, opened and closed together, and the guard that stops it."""

import threading
import time
from contextlib import ExitStack
from pathlib import Path

from hardware.p3dx import P3dx
from hardware.staleness_guard import StalenessGuard
from hardware.urg04lx import Urg04lx
from hardware.wire.session import WireSession
from slam.scenario.schema import Scenario


class RobotDevices:
    """Base and lidar of a scenario, opened when made; RobotError names the one that does not answer.

    Once ``leaving`` is set, nothing waits for a device any more. ``record_wire`` gets every byte of both ports.
    """

    def __init__(self, scenario: Scenario, leaving: threading.Event, record_wire: Path | None = None) -> None:
        self._config = scenario.hardware
        self._leaving = leaving
        self.commanded_at = 0.0
        """Time of the newest command, seconds of ``time.monotonic``."""
        with ExitStack() as opened:
            wire = opened.enter_context(WireSession(record_wire))
            self.lidar = Urg04lx(self._config, scenario.lidar.description.lidar.range_max, leaving, wire)
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
        """Reason why the robot stands although it is told to drive, or has no data; None when all is well."""
        return self.base.manual_stop or self.base.trouble or self.lidar.trouble or self.guard.reason

    def _ages(self) -> dict[str, tuple[float, float]]:
        config, now = self._config, time.monotonic()
        return {
            "command": (now - self.commanded_at, config.command_timeout),
            "scan": (now - self.lidar.scanned_at, config.data_timeout),
            "odometry": (now - self.base.reported_at, config.data_timeout),
        }
