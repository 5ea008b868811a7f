"""Faults of emulated devices, on a schedule: ``lidar:unplug@10+5`` unplugs the lidar after 10 s, for 5 s."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Final

from hardware.emulator.emulator import Emulator
from hardware.emulator.p3dx_reports import FULL_BATTERY
from slam.errors import InputError

_FORM: Final = re.compile(r"(robot|lidar):([a-z-]+)@(\d+(?:\.\d*)?)(?:\+(\d+(?:\.\d*)?))?")
Action = Callable[[Emulator], object]

DEVICE_FAULTS: Final[dict[tuple[str, str], tuple[Action, Action]]] = {
    ("robot", "unplug"): (lambda e: e.robot.unplug(), lambda e: e.robot.port.open()),
    ("lidar", "unplug"): (lambda e: e.lidar.unplug(), lambda e: e.lidar.port.open()),
    ("robot", "stall"): (lambda e: e.robot.stall(inf), lambda e: e.robot.stall(-inf)),
    ("lidar", "stall"): (lambda e: e.lidar.stall(inf), lambda e: e.lidar.stall(-inf)),
    ("robot", "e-stop"): (lambda e: e.p3dx.motors.press_e_stop(True), lambda e: e.p3dx.motors.press_e_stop(False)),
    ("robot", "motors-off"): (lambda e: e.p3dx.motors.enable(False), lambda e: e.p3dx.motors.enable(True)),
    ("robot", "battery-low"): (lambda e: e.p3dx.set_battery(11.3), lambda e: e.p3dx.set_battery(FULL_BATTERY)),
    ("robot", "battery-empty"): (lambda e: e.p3dx.set_battery(10.8), lambda e: e.p3dx.set_battery(FULL_BATTERY)),
    ("lidar", "reboot"): (lambda e: e.scanner.reboot(e.now), lambda _: None),
    ("lidar", "dead"): (lambda e: e.scanner.set_dead(True), lambda e: e.scanner.set_dead(False)),
}
"""Begin and end of each fault, by device and kind; both are called on the emulator's thread."""


@dataclass(frozen=True, slots=True)
class TimedFault:
    """Fault of a device, its start and its duration, seconds; None stays for good."""

    device: str
    kind: str
    at: float
    seconds: float | None

    @classmethod
    def parse(cls, text: str) -> TimedFault:
        """Read ``device:kind@at+seconds``; InputError for anything else."""
        found = _FORM.fullmatch(text)
        if found is None or (found[1], found[2]) not in DEVICE_FAULTS:
            known = ", ".join(f"{device}:{kind}" for device, kind in DEVICE_FAULTS)
            raise InputError(f"--fault {text}: expected for example lidar:unplug@10+5; known are {known}")
        return cls(found[1], found[2], float(found[3]), None if found[4] is None else float(found[4]))

    def schedule(self, emulator: Emulator) -> None:
        """Schedule the fault, before the emulator is entered."""
        begin, end = DEVICE_FAULTS[self.device, self.kind]
        emulator.schedule(self.at, lambda: begin(emulator))
        if self.seconds is not None:
            emulator.schedule(self.at + self.seconds, lambda: end(emulator))
