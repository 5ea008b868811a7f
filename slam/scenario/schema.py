"""A scenario: a world, a robot in it, where it goes, and the method that maps it. Read from YAML."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from slam.config import Section, SlamConfig
from slam.scenario.clock import Clock, make_clock
from slam.scenario.generators.kinds import Generator
from slam.scenario.hardware_config import HardwareConfig
from slam.scenario.lidar_config import LidarConfig
from slam.scenario.people import Person
from slam.scenario.robot_config import RobotConfig
from slam.scenario.values import Point, Positive, Small, Speed, TurnSpeed
from slam.scenario.world_plan import World


class Route(Section):
    """Way-points, followed one after another on the estimated pose."""

    waypoints: tuple[Point, ...] = ()
    """Map frame, metres; none: the robot stands. Left out where a world is generated: a tour of it."""
    speed: Speed = 0.5
    """m/s."""
    turn_speed: TurnSpeed = 0.8
    """rad/s."""
    arrival: Small = 0.15
    """A way-point is reached within this distance, metres."""


class Physics(Section):
    """The clock of the simulation."""

    rate: Annotated[int, Field(ge=60, le=10_000)] = 240
    """Physics steps a second."""


class Scenario(Section):
    """One whole experiment."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    """Of the run folders too."""
    description: str = ""
    """In one line."""
    generate: Generator | None = None
    """Makes a world, a route and people from a seed, when the scenario is loaded; written by hand, they add to it."""
    world: World = World()
    people: tuple[Person, ...] = ()
    """Who walks there."""
    robot: RobotConfig = RobotConfig()
    lidar: LidarConfig = LidarConfig()
    hardware: HardwareConfig = HardwareConfig()
    route: Route = Route()
    physics: Physics = Physics()
    slam: SlamConfig = SlamConfig()
    duration: Positive = 600.0
    """The run ends after this many simulated seconds at the latest."""
    seed: int = Field(0, ge=0)
    """Of all that is random: values that the file leaves to chance, noise of the lidar and the wheels, map points."""

    @property
    def clock(self) -> Clock:
        """How physics, control and scans divide the time."""
        lidar = self.lidar.description.lidar
        sweep = (lidar.beams - 1) * self.lidar.time_increment
        return make_clock(self.physics.rate, self.robot.control_rate, lidar.scan_time, sweep)

    @model_validator(mode="after")
    def _the_clocks_divide(self) -> Self:
        scan_time = self.lidar.description.lidar.scan_time
        if self.duration < scan_time:
            raise ValueError(f"duration = {self.duration:g} s ends before the first scan, which takes {scan_time:g} s")
        _ = self.clock
        return self
