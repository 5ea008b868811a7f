"""Benchmark of faults: time until the robot stops, the reason that is given, and the recovery after the fault."""

import os
import signal
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from hardware.bench.emulated_robot import FORWARD, EmulatedRobot, emulated_devices, emulated_robot, seconds_until
from hardware.emulator.emulator import Emulator
from hardware.emulator.faults import DEVICE_FAULTS, Action
from hardware.emulator.motor_controller import MotorController
from hardware.robot import HardwareRobot
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

if sys.platform != "linux":
    raise ImportError("hopslam bench hardware runs on Linux")


@dataclass(frozen=True, slots=True)
class FaultResult:
    """Outcome of a fault; seconds are None if the event never happened."""

    name: str
    to_stand: float | None
    """Seconds from the fault until the robot is at rest."""
    stopped_by: str
    reason: str
    """Reason that the driver gave."""
    to_drive: float | None
    """Seconds from the end of the fault to the next motion."""


FAULTS: Final[dict[str, tuple[str, str]]] = {
    "lidar unplugged, plugged in": ("lidar", "unplug"),
    "lidar stalls for 3 s": ("lidar", "stall"),
    "lidar dead, alive": ("lidar", "dead"),
    "emergency stop, released": ("robot", "e-stop"),
    "motors switched off, on": ("robot", "motors-off"),
}
"""Faults during which commands reach the robot, or a person operates it: device and kind by name."""
CUT_OFF: Final[dict[str, tuple[str, str]]] = {
    "robot unplugged, plugged in": ("robot", "unplug"),
    "robot stalls for 3 s": ("robot", "stall"),
}
"""Faults during which nothing reaches the robot."""
_DURATION: Final = 3.0
"""Seconds from a fault to its end."""
_TIME_LIMIT: Final = 30.0
"""Seconds within which a program starts to drive, or its robot comes to rest."""


def fault_results(
    faults: Mapping[str, tuple[str, str]], watchdog: float, settings: Sequence[str] = ()
) -> Iterator[FaultResult]:
    """Measure each fault on a robot that drives, with this watchdog, seconds."""
    with emulated_robot(watchdog, settings) as emulated:
        for name, fault in faults.items():
            yield _fault_result(emulated, name, *DEVICE_FAULTS[fault])


def _fault_result(emulated: EmulatedRobot, name: str, begin: Action, end: Action) -> FaultResult:
    emulator, motors = emulated.emulator, emulated.emulator.p3dx.motors
    emulated.drive_until(lambda: emulator.p3dx.motors.setpoint.linear > 0.9 * FORWARD.linear)
    emulator.do(lambda: begin(emulator))
    cured_at = time.monotonic() + _DURATION
    to_stand = emulated.drive_until(lambda: emulated.standing, _DURATION)
    stopped_by = _stopper(motors)
    while time.monotonic() < cured_at:
        emulated.step()
    reason = (emulated.robot.trouble or "none").split(";")[0]
    emulator.do(lambda: end(emulator))
    return FaultResult(name, to_stand, stopped_by, reason, emulated.drive_until(lambda: not emulated.standing))


def kill_result(watchdog: float, settings: Sequence[str] = ()) -> FaultResult:
    """Kill a driving program, a fork of this one, with SIGKILL, and let another program find its emulated robot."""
    with emulated_devices(load_scenario("corridor", settings), watchdog) as emulator:
        scenario = load_scenario("corridor", [*settings, *emulator.port_settings])
        program = os.fork()
        if not program:
            _drive_for_ever(scenario)
        with emulator:
            return _killed(emulator, scenario, program)


def _killed(emulator: Emulator, scenario: Scenario, program: int) -> FaultResult:
    seconds_until(lambda: emulator.p3dx.motors.setpoint.linear > 0.9 * FORWARD.linear, _TIME_LIMIT)
    os.kill(program, signal.SIGKILL)
    os.waitpid(program, 0)
    to_stand = seconds_until(lambda: not emulator.p3dx.motors.moving, _TIME_LIMIT)
    stopped_by = _stopper(emulator.p3dx.motors)
    with HardwareRobot(scenario, yes=True) as robot:
        emulated = EmulatedRobot(emulator, robot)
        to_drive = emulated.drive_until(lambda: not emulated.standing)
    return FaultResult("kill -9, started again", to_stand, stopped_by, "(the program was killed)", to_drive)


def _drive_for_ever(scenario: Scenario) -> None:
    with HardwareRobot(scenario, yes=True) as robot:
        while True:
            robot.drive(FORWARD)
            robot.observe()


def _stopper(motors: MotorController) -> str:
    """Return the reason why the robot does not move, as its firmware knows it."""
    if motors.e_stop:
        return "emergency stop"
    if not motors.enabled:
        return "motor button"
    return "watchdog" if motors.watchdog_expired else "driver"
