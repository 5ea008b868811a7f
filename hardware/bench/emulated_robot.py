"""The drivers and the emulated devices in one process, for the benchmarks to measure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Final

from hardware.emulator.emulator import Emulator
from hardware.emulator.p3dx import FACTORY_CONFIG
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
class EmulatedRobot:
    """The drivers of a robot whose devices are emulated in the corridor, moved by the PyBullet world."""

    emulator: Emulator
    robot: HardwareRobot

    @property
    def standing(self) -> bool:
        """True while the motors stand."""
        return not self.emulator.p3dx.motors.moving

    def step(self) -> Observation | None:
        """Drive on, as a run does, and return the observation; None while nothing comes."""
        self.robot.drive(FORWARD)
        try:
            return self.robot.observe(0.05)
        except RobotTimeout:
            return None

    def drive_until(self, condition: Callable[[], bool], patience: float = 20.0) -> float | None:
        """Drive until the condition is true, and return the seconds; None where it never became true."""
        began = monotonic()
        while monotonic() - began < patience:
            if condition():
                return monotonic() - began
            self.step()
        return None


@contextmanager
def emulated_robot(watchdog: float = FACTORY_CONFIG.watchdog) -> Iterator[EmulatedRobot]:
    """Emulate both devices on pseudo-terminals, the robot with this watchdog in its FLASH, seconds, and drive them."""
    with (
        emulated_devices(load_scenario("corridor"), watchdog) as emulator,
        emulator,
        HardwareRobot(load_scenario("corridor", port_settings(emulator)), yes=True) as robot,
    ):
        yield EmulatedRobot(emulator, robot)


@contextmanager
def emulated_devices(
    scenario: Scenario, watchdog: float = FACTORY_CONFIG.watchdog, plant: str = "sim"
) -> Iterator[Emulator]:
    """Emulate both devices in the scenario's world, moved by this plant, not begun yet.

    They are at links: a terminal that was unplugged may come back under another number.
    """
    config = replace(FACTORY_CONFIG, watchdog=watchdog)
    with TemporaryDirectory(prefix="hopslam-") as links:
        ports = PtyPort(Path(links) / "p3dx"), PtyPort(Path(links) / "urg04lx")
        yield Emulator(make_plant(plant, scenario), *ports, seed=scenario.seed, robot_config=config)


def port_settings(emulator: Emulator) -> list[str]:
    """Return the settings of a scenario that name the emulator's ports."""
    robot, lidar = emulator.robot.port.address, emulator.lidar.port.address
    return [f"hardware.robot_port={robot}", f"hardware.lidar_port={lidar}"]
