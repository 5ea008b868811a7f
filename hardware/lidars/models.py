"""The lidars that a real robot can carry, by name: their drivers and emulators, imported when they are used."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Protocol, cast

from hardware.scan_queue import ScanQueue
from hardware.wire.session import WireSession
from slam.errors import ScenarioError
from slam.lidars import LidarModel
from slam.named_code import import_by_name
from slam.scenario.hardware_config import HardwareConfig


class LidarDriver(Protocol):
    """An open lidar, whose own thread receives its scans."""

    scans: ScanQueue

    @property
    def period(self) -> float:
        """Seconds from scan to scan, at the present speed."""
        ...

    @property
    def trouble(self) -> str | None:
        """Reason why no scans arrive; None if they do."""
        ...

    def close(self) -> None:
        """Close the lidar; closing twice is allowed."""
        ...


OpenLidar = Callable[[HardwareConfig, LidarModel, threading.Event, WireSession], LidarDriver]


@dataclass(frozen=True, slots=True)
class LidarDevice:
    """Places, ``module:Class``, of the driver of a lidar, if it has one, and of its emulator."""

    driver: str | None
    emulator: str


LIDAR_DEVICES: Final = {
    "urg04lx": LidarDevice("hardware.urg04lx:Urg04lx", "hardware.emulator.urg04lx:EmulatedUrg04lx"),
    "table1": LidarDevice(None, "hardware.emulator.urg04lx:EmulatedTable1"),  # it reports the name URG-04LX
    "ld19": LidarDevice("hardware.lidars.ld19:Ld19", "hardware.emulator.ld19:EmulatedLd19"),
}
"""Every lidar with a driver or emulator, by its name in ``slam/lidars.py``."""


def lidar_driver(model: str) -> OpenLidar:
    """Return the class of the driver for this model; ScenarioError if there is none."""
    device = LIDAR_DEVICES.get(model)
    if device is None or device.driver is None:
        known = " or ".join(name for name, one in LIDAR_DEVICES.items() if one.driver)
        raise ScenarioError(f"lidar.model: {model} is only simulated; set lidar.model={known}")
    return cast(OpenLidar, import_by_name(device.driver))


def lidar_emulator(model: str) -> Any:
    """Return the class of the emulator for this model; ScenarioError if there is none."""
    if model not in LIDAR_DEVICES:
        raise ScenarioError(f"lidar.model: {model} cannot be emulated; set lidar.model={' or '.join(LIDAR_DEVICES)}")
    return import_by_name(LIDAR_DEVICES[model].emulator)
