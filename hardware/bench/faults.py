"""Faults, one after another: how soon the robot stands, what it says, and whether the cure brings it back."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from hardware.bench.bench import FORWARD, Bench, bench
from hardware.emulator.emulator import Emulator

Act = Callable[[Emulator], object]


@dataclass(frozen=True, slots=True)
class FaultResult:
    """Seconds from the fault to a standing robot, the reason that was named, and seconds from the cure to the next
    motion; None for never."""

    name: str
    to_stand: float | None
    reason: str
    to_drive: float | None


_FAULTS: tuple[tuple[str, Act, Act], ...] = (
    ("lidar unplugged, plugged in", lambda e: e.lidar.unplug(), lambda e: e.lidar.port.open()),
    ("lidar stalls for 3 s", lambda e: e.lidar.stall(float("inf")), lambda e: e.lidar.stall(float("-inf"))),
    ("lidar dead, alive", lambda e: e.urg04lx.die(True), lambda e: e.urg04lx.die(False)),
    ("robot unplugged, plugged in", lambda e: e.robot.unplug(), lambda e: e.robot.port.open()),
    ("robot stalls for 3 s", lambda e: e.robot.stall(float("inf")), lambda e: e.robot.stall(float("-inf"))),
    ("emergency stop, released", lambda e: e.p3dx.motion.press(True), lambda e: e.p3dx.motion.press(False)),
    ("motors switched off, on", lambda e: e.p3dx.motion.enable(False), lambda e: e.p3dx.motion.enable(True)),
)
_LASTS = 3.0
"""Seconds from a fault to its cure."""


def fault_results(at: Bench) -> Iterator[FaultResult]:
    """Each fault while the robot drives."""
    for name, fault, cure in _FAULTS:
        at.drive_until(lambda: at.emulator.p3dx.motion.setpoint.linear > 0.9 * FORWARD.linear)
        at.emulator.do(partial(fault, at.emulator))
        cured_at = time.monotonic() + _LASTS
        to_stand = at.drive_until(lambda: at.standing, _LASTS)
        while time.monotonic() < cured_at:
            at.step()
        reason = (at.robot.trouble or "none").split(";")[0]
        at.emulator.do(partial(cure, at.emulator))
        yield FaultResult(name, to_stand, reason, at.drive_until(lambda: not at.standing))


def kill_result() -> FaultResult:
    """kill -9 of a program that drives: a fork of this one, whose emulated robot stays."""
    from hardware.robot import HardwareRobot
    from slam.run.backends import make_plant
    from slam.run.scenario.file import load_scenario

    emulator = Emulator(make_plant("sim", load_scenario("corridor")))
    ports = emulator.robot.port.address, emulator.lidar.port.address
    scenario = load_scenario("corridor", [f"hardware.robot_port={ports[0]}", f"hardware.lidar_port={ports[1]}"])
    program = os.fork()
    if not program:
        with HardwareRobot(scenario, yes=True) as robot:
            while True:
                robot.drive(FORWARD)
                robot.observe()
    with emulator:
        _wait(lambda: emulator.p3dx.motion.setpoint.linear > 0.9 * FORWARD.linear)
        os.kill(program, signal.SIGKILL)
        os.waitpid(program, 0)
        to_stand = _wait(lambda: not emulator.p3dx.motion.moving)
        with HardwareRobot(scenario, yes=True) as robot:
            again = Bench(emulator, robot)
            to_drive = again.drive_until(lambda: not again.standing)
    return FaultResult("kill -9, started again", to_stand, "the robot's watchdog", to_drive)


def _wait(condition: Callable[[], bool], patience: float = 30.0) -> float | None:
    began = time.monotonic()
    while time.monotonic() - began < patience:
        if condition():
            return time.monotonic() - began
        time.sleep(0.002)
    return None


def all_faults() -> list[FaultResult]:
    """On one bench, then the kill on another."""
    killed = kill_result()
    with bench() as at:
        return [*fault_results(at), killed]
