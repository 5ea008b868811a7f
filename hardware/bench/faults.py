"""Faults, one after another: how soon the robot stands, what it says, and whether the cure brings it back."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from hardware.bench.bench import FORWARD, Bench, bench, emulated, port_settings
from hardware.emulator.emulator import Emulator
from hardware.emulator.motion import Motion
from hardware.robot import HardwareRobot
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

Act = Callable[[Emulator], object]


@dataclass(frozen=True, slots=True)
class FaultResult:
    """Seconds from the fault to a standing robot, what made it stand, the reason that was named, and seconds from the
    cure to the next motion; None for never."""

    name: str
    to_stand: float | None
    stopped_by: str
    reason: str
    to_drive: float | None


@dataclass(frozen=True, slots=True)
class _Fault:
    name: str
    begin: Act
    end: Act


FAULTS: Final = (
    _Fault("lidar unplugged, plugged in", lambda e: e.lidar.unplug(), lambda e: e.lidar.port.open()),
    _Fault("lidar stalls for 3 s", lambda e: e.lidar.stall(float("inf")), lambda e: e.lidar.stall(float("-inf"))),
    _Fault("lidar dead, alive", lambda e: e.urg04lx.die(True), lambda e: e.urg04lx.die(False)),
    _Fault("emergency stop, released", lambda e: e.p3dx.motion.press(True), lambda e: e.p3dx.motion.press(False)),
    _Fault("motors switched off, on", lambda e: e.p3dx.motion.enable(False), lambda e: e.p3dx.motion.enable(True)),
)
"""Where a command still reaches the robot, or somebody's hand does."""
CUT_OFF: Final = (
    _Fault("robot unplugged, plugged in", lambda e: e.robot.unplug(), lambda e: e.robot.port.open()),
    _Fault("robot stalls for 3 s", lambda e: e.robot.stall(float("inf")), lambda e: e.robot.stall(float("-inf"))),
)
"""Where nothing reaches it."""
_LASTS: Final = 3.0
"""Seconds from a fault to its cure."""


def fault_results(faults: Sequence[_Fault], watchdog: float) -> Iterator[FaultResult]:
    """Each fault while a robot drives whose watchdog waits for so long, seconds."""
    with bench(watchdog) as at:
        for fault in faults:
            yield _happen(at, fault)


def _happen(at: Bench, fault: _Fault) -> FaultResult:
    motion = at.emulator.p3dx.motion
    at.drive_until(lambda: at.emulator.p3dx.motion.setpoint.linear > 0.9 * FORWARD.linear)
    at.emulator.do(partial(fault.begin, at.emulator))
    cured_at = time.monotonic() + _LASTS
    to_stand = at.drive_until(lambda: at.standing, _LASTS)
    stopped_by = _stopper(motion)
    while time.monotonic() < cured_at:
        at.step()
    reason = (at.robot.trouble or "none").split(";")[0]
    at.emulator.do(partial(fault.end, at.emulator))
    return FaultResult(fault.name, to_stand, stopped_by, reason, at.drive_until(lambda: not at.standing))


def kill_result(watchdog: float) -> FaultResult:
    """kill -9 of a program that drives: a fork of this one, whose emulated robot stays. The next program finds it."""
    with emulated(load_scenario("corridor"), watchdog) as emulator:
        scenario = load_scenario("corridor", port_settings(emulator))
        program = os.fork()
        if not program:
            _drive_for_ever(scenario)
        with emulator:
            return _killed(emulator, scenario, program)


def _killed(emulator: Emulator, scenario: Scenario, program: int) -> FaultResult:
    _wait(lambda: emulator.p3dx.motion.setpoint.linear > 0.9 * FORWARD.linear)
    os.kill(program, signal.SIGKILL)
    os.waitpid(program, 0)
    to_stand = _wait(lambda: not emulator.p3dx.motion.moving)
    stopped_by = _stopper(emulator.p3dx.motion)
    with HardwareRobot(scenario, yes=True) as robot:
        again = Bench(emulator, robot)
        to_drive = again.drive_until(lambda: not again.standing)
    return FaultResult("kill -9, started again", to_stand, stopped_by, "(nobody is left to name one)", to_drive)


def _drive_for_ever(scenario: Scenario) -> None:
    with HardwareRobot(scenario, yes=True) as robot:
        while True:
            robot.drive(FORWARD)
            robot.observe()


def _stopper(motion: Motion) -> str:
    """What keeps the robot from moving, as its firmware knows it."""
    if motion.e_stop:
        return "emergency stop"
    if not motion.enabled:
        return "motor button"
    return "watchdog" if motion.starved else "driver"


def _wait(condition: Callable[[], bool], patience: float = 30.0) -> float | None:
    began = time.monotonic()
    while time.monotonic() - began < patience:
        if condition():
            return time.monotonic() - began
        time.sleep(0.002)
    return None
