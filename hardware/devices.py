"""The two devices of a robot, opened and closed together, and the guard that stops it."""

import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Final, Protocol

from hardware.ld19 import Ld19
from hardware.p3dx import P3dx
from hardware.scan_queue import ScanQueue
from hardware.staleness_guard import StalenessGuard
from hardware.urg04lx import Urg04lx
from hardware.wire.session import WireSession
from slam.errors import ScenarioError
from slam.lidars import LidarModel
from slam.scenario.hardware_config import HardwareConfig
from slam.scenario.schema import Scenario


class LidarDriver(Protocol):
    """A lidar that was opened, whose scans come by themselves, on a thread of its own."""

    scans: ScanQueue

    @property
    def period(self) -> float:
        """Seconds from scan to scan, as it turns now."""
        ...

    @property
    def trouble(self) -> str | None:
        """Reason why no scans come; None when they do."""
        ...

    def close(self) -> None:
        """Let go of the lidar; closing twice is allowed."""
        ...


MakeLidar = Callable[[HardwareConfig, LidarModel, threading.Event, WireSession], LidarDriver]
_DRIVERS: Final[dict[str, MakeLidar]] = {"urg04lx": Urg04lx, "ld19": Ld19}
_LOST_SCANS: Final = 3.0
"""Scan periods without a scan, at least, after which the robot is stopped: one lost scan of a slow lidar is none."""


def lidar_driver(model: str) -> MakeLidar:
    """Return what opens a lidar of this model; ScenarioError where there is no driver for it."""
    if model not in _DRIVERS:
        raise ScenarioError(f"lidar.model: {model} is only simulated; set lidar.model={' or '.join(_DRIVERS)}")
    return _DRIVERS[model]


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
        """Reason why the robot stands although it is told to drive, or has no data; None when all is well."""
        return self.base.manual_stop or self.base.trouble or self.lidar.trouble or self.guard.reason

    @property
    def limits(self) -> dict[str, float]:
        """Seconds after which a command, a scan and odometry are too old to drive on."""
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
