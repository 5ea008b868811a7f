"""Drivers and emulated devices in one process, ready to be measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Final

from hardware.emulator.emulator import Emulator
from hardware.emulator.motion import FACTORY
from hardware.emulator.ports import PtyPort
from hardware.robot import HardwareRobot
from slam.errors import RobotTimeout
from slam.odometry import Twist2D
from slam.robot import Observation
from slam.run.backends import make_plant
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

FORWARD: Final = Twist2D(0.3, 0.0)


@dataclass(frozen=True, slots=True)
class Bench:
    """A robot that drives through the corridor, moved by the PyBullet world."""

    emulator: Emulator
    robot: HardwareRobot

    @property
    def standing(self) -> bool:
        """Whether the motors stand."""
        return not self.emulator.p3dx.motion.moving

    def step(self) -> Observation | None:
        """Drive on, as a run does; None while nothing comes."""
        self.robot.drive(FORWARD)
        try:
            return self.robot.observe(0.05)
        except RobotTimeout:
            return None

    def drive_until(self, condition: Callable[[], bool], patience: float = 20.0) -> float | None:
        """Seconds until it was true; None where it never became true."""
        began = monotonic()
        while monotonic() - began < patience:
            if condition():
                return monotonic() - began
            self.step()
        return None


@contextmanager
def bench(watchdog: float = FACTORY.watchdog) -> Iterator[Bench]:
    """Both on pseudo-terminals, the lidar on USB, the robot at 38400 baud with this watchdog in its FLASH, seconds."""
    with (
        emulated(load_scenario("corridor"), watchdog) as emulator,
        emulator,
        HardwareRobot(load_scenario("corridor", port_settings(emulator)), yes=True) as robot,
    ):
        yield Bench(emulator, robot)


@contextmanager
def emulated(scenario: Scenario, watchdog: float = FACTORY.watchdog, plant: str = "sim") -> Iterator[Emulator]:
    """Both devices in the scenario's world, moved by this plant, not begun yet.

    They are at links: a terminal that was unplugged may come back under another number.
    """
    config = replace(FACTORY, watchdog=watchdog)
    with TemporaryDirectory(prefix="hopslam-") as links:
        ports = PtyPort(Path(links) / "p3dx"), PtyPort(Path(links) / "urg04lx")
        yield Emulator(make_plant(plant, scenario), *ports, seed=scenario.seed, robot_config=config)


def port_settings(emulator: Emulator) -> list[str]:
    """The settings of a scenario that name its ports."""
    robot, lidar = emulator.robot.port.address, emulator.lidar.port.address
    return [f"hardware.robot_port={robot}", f"hardware.lidar_port={lidar}"]
