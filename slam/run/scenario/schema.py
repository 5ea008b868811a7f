"""A scenario: a world, a robot in it, where it goes, and the method that maps it. Read from YAML."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from slam.config import Section, SlamConfig
from slam.run.scenario.hardware_config import HardwareConfig
from slam.run.scenario.lidar_config import LidarConfig
from slam.run.scenario.people import Person
from slam.run.scenario.robot_config import RobotConfig
from slam.run.scenario.values import Point, Positive
from slam.run.scenario.world_plan import World


class Route(Section):
    """Way-points, followed one after another on the estimated pose."""

    waypoints: tuple[Point, ...] = ()
    """Map frame, metres; none: the robot stands."""
    speed: Positive = 0.5
    """m/s."""
    turn_speed: Positive = 0.8
    """rad/s."""
    arrival: Positive = 0.15
    """A way-point is reached within this distance, metres."""


class Physics(Section):
    """The clock of the simulation."""

    rate: Annotated[int, Field(ge=60)] = 240
    """Physics steps a second."""


class Scenario(Section):
    """One whole experiment."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    """Of the run folders too."""
    description: str = ""
    world: World = World()
    people: tuple[Person, ...] = ()
    robot: RobotConfig = RobotConfig()
    lidar: LidarConfig = LidarConfig()
    hardware: HardwareConfig = HardwareConfig()
    route: Route = Route()
    physics: Physics = Physics()
    slam: SlamConfig = SlamConfig()
    duration: Positive = 600.0
    """The run ends after this many simulated seconds at the latest."""
    seed: int = Field(0, ge=0)
    """Of all that is random: noise of the lidar and the wheels, and the draw of map points."""

    @property
    def steps_per_scan(self) -> int:
        """Physics steps from one scan to the next."""
        return round(self.physics.rate * self.lidar.description.lidar.scan_time)

    @model_validator(mode="after")
    def _scans_fall_on_physics_steps(self) -> Self:
        scan_time = self.lidar.description.lidar.scan_time
        if self.duration < scan_time:
            raise ValueError(f"duration = {self.duration:g} s ends before the first scan, which takes {scan_time:g} s")
        if abs(self.physics.rate * scan_time - self.steps_per_scan) > 1e-9:
            raise ValueError(
                f"physics.rate = {self.physics.rate} gives {self.physics.rate * scan_time:g} steps in the "
                f"{scan_time:g} s of a scan; choose a rate that gives a whole number"
            )
        return self
