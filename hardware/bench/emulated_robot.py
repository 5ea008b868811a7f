"""The drivers and the emulated devices in one process, for benchmarks, and the measurement of their load."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, process_time, sleep
from typing import Final

import numpy as np

from hardware.emulator.emulator import Emulator, emulated_lidar
from hardware.emulator.p3dx import FACTORY_CONFIG
from hardware.emulator.ports import pseudo_terminal
from hardware.robot import HardwareRobot
from slam.errors import RobotTimeout
from slam.odometry import Twist2D
from slam.robot import Observation
from slam.run.backends import make_plant
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

FORWARD: Final = Twist2D(0.3, 0.0)


@dataclass(frozen=True, slots=True)
class EmulatedRobot:
    """Drivers of a robot whose devices are emulated in the corridor, moved by the PyBullet world."""

    emulator: Emulator
    robot: HardwareRobot

    @property
    def standing(self) -> bool:
        """True while the motors are at rest."""
        return not self.emulator.p3dx.motors.moving

    def step(self) -> Observation | None:
        """Repeat the command, as a run does, and return the observation; None if none arrives."""
        self.robot.drive(FORWARD)
        try:
            return self.robot.observe(0.05)
        except RobotTimeout:
            return None

    def drive_until(self, condition: Callable[[], bool], patience: float = 20.0) -> float | None:
        """Drive until the condition is true, and return the seconds; None if it never became true."""
        return seconds_until(condition, patience, self.step)


def seconds_until(
    condition: Callable[[], bool], patience: float, meanwhile: Callable[[], object] = lambda: sleep(0.002)
) -> float | None:
    """Call ``meanwhile`` until the condition is true, and return the seconds; None after ``patience`` seconds."""
    began = monotonic()
    while monotonic() - began < patience:
        if condition():
            return monotonic() - began
        meanwhile()
    return None


@contextmanager
def emulated_robot(watchdog: float = FACTORY_CONFIG.watchdog, settings: Sequence[str] = ()) -> Iterator[EmulatedRobot]:
    """Emulate both devices on pseudo-terminals, and connect the drivers.

    ``watchdog`` is set in the robot's FLASH, seconds; ``settings`` are those of the scenario.
    """
    with (
        emulated_devices(load_scenario("corridor", settings), watchdog) as emulator,
        emulator,
        HardwareRobot(load_scenario("corridor", [*settings, *emulator.port_settings]), yes=True) as robot,
    ):
        yield EmulatedRobot(emulator, robot)


@contextmanager
def emulated_devices(
    scenario: Scenario, watchdog: float = FACTORY_CONFIG.watchdog, plant: str = "sim"
) -> Iterator[Emulator]:
    """Make an emulator of both devices in the scenario's world, moved by this plant; it is not started yet.

    The devices are at links, as a terminal that was unplugged may return under another number.
    """
    config = replace(FACTORY_CONFIG, watchdog=watchdog)
    with TemporaryDirectory(prefix="hopslam-") as links:
        ports = pseudo_terminal(Path(links) / "p3dx"), pseudo_terminal(Path(links) / "lidar")
        yield Emulator(
            make_plant(plant, scenario), *ports, seed=scenario.seed, robot_config=config, lidar=emulated_lidar(scenario)
        )


@dataclass(frozen=True, slots=True)
class Load:
    """The load of drivers, emulator and physics: ``cpu`` is a share of one core, latencies are seconds."""

    cpu: float
    scans: int
    seconds: float
    latency_median: float
    latency_p99: float


def measure_load(emulated: EmulatedRobot, seconds: float) -> Load:
    """Measure the load while driving for ``seconds``."""
    emulated.drive_until(lambda: not emulated.standing)
    began, busy = monotonic(), process_time()
    latencies = []
    while monotonic() - began < seconds:
        observation = emulated.step()
        if observation is not None:
            scan = observation.scan
            sweep = max(0.0, (len(scan.ranges) - 1) * scan.time_increment)  # a clockwise scan is stamped at its end
            last_beam = (emulated.robot.epoch or 0.0) + scan.stamp + sweep
            latencies.append(monotonic() - last_beam)
    cpu = (process_time() - busy) / (monotonic() - began)
    return Load(cpu, len(latencies), seconds, float(np.median(latencies)), float(np.quantile(latencies, 0.99)))
