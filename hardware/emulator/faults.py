"""Faults by the clock: ``lidar:unplug@10+5`` pulls the lidar's plug after ten seconds, for five."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from hardware.emulator.emulator import Emulator
from slam.errors import InputError

_FORM: Final = re.compile(r"(robot|lidar):([a-z-]+)@(\d+(?:\.\d*)?)(?:\+(\d+(?:\.\d*)?))?")
Call = Callable[[], object]


@dataclass(frozen=True, slots=True)
class Fault:
    """What happens to which device, when, and for how long, seconds; without an end it stays."""

    device: str
    kind: str
    at: float
    seconds: float | None

    @classmethod
    def parse(cls, text: str) -> Fault:
        """From ``device:kind@at+seconds``; InputError for anything else."""
        found = _FORM.fullmatch(text)
        if found is None or (found[1], found[2]) not in _KINDS:
            known = ", ".join(f"{device}:{kind}" for device, kind in _KINDS)
            raise InputError(f"--fault {text}: expected for example lidar:unplug@10+5; known are {known}")
        return cls(found[1], found[2], float(found[3]), None if found[4] is None else float(found[4]))

    def plan(self, emulator: Emulator) -> None:
        """Let it happen."""
        begin, end = _KINDS[self.device, self.kind](emulator)
        emulator.plan(self.at, begin)
        if self.seconds is not None:
            emulator.plan(self.at + self.seconds, end)


def _plug(device: str) -> Callable[[Emulator], tuple[Call, Call]]:
    def calls(emulator: Emulator) -> tuple[Call, Call]:
        station = getattr(emulator, device)
        return station.unplug, station.port.open

    return calls


def _stall(device: str) -> Callable[[Emulator], tuple[Call, Call]]:
    def calls(emulator: Emulator) -> tuple[Call, Call]:
        station = getattr(emulator, device)
        return lambda: station.stall(float("inf")), lambda: station.stall(float("-inf"))

    return calls


def _e_stop(emulator: Emulator) -> tuple[Call, Call]:
    return lambda: emulator.p3dx.motion.press(True), lambda: emulator.p3dx.motion.press(False)


def _motors(emulator: Emulator) -> tuple[Call, Call]:
    return lambda: emulator.p3dx.motion.enable(False), lambda: emulator.p3dx.motion.enable(True)


def _dead(emulator: Emulator) -> tuple[Call, Call]:
    return lambda: emulator.urg04lx.die(True), lambda: emulator.urg04lx.die(False)


_KINDS: Final = {
    ("robot", "unplug"): _plug("robot"),
    ("lidar", "unplug"): _plug("lidar"),
    ("robot", "stall"): _stall("robot"),
    ("lidar", "stall"): _stall("lidar"),
    ("robot", "e-stop"): _e_stop,
    ("robot", "motors-off"): _motors,
    ("lidar", "dead"): _dead,
}
