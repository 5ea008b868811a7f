"""A scenario: a world, a robot in it, where it goes, and the method that maps it. Read from YAML."""

from typing import Annotated, Any, Self

from pydantic import Discriminator, Field, Tag, model_validator

from slam.config import Section, SlamConfig
from slam.scenario.clock import Clock, Physics, make_clock
from slam.scenario.generators.campus import CampusGenerator
from slam.scenario.generators.corridor import CorridorGenerator
from slam.scenario.generators.loop import LoopGenerator
from slam.scenario.generators.office import OfficeGenerator
from slam.scenario.hardware_config import HardwareConfig
from slam.scenario.lidar_config import LidarConfig
from slam.scenario.robot_config import RobotConfig
from slam.scenario.ros_config import RosConfig
from slam.scenario.values import Point, Positive, SmallLength, Speed, TurnSpeed
from slam.scenario.world_plan import Person, World


class Route(Section):
    """Way-points, followed one after another on the estimated pose."""

    waypoints: tuple[Point, ...] = ()
    """Map frame, metres; none: the robot stands. Left out where a world is generated: a tour of it."""
    speed: Speed = 0.5
    """Speed, m/s."""
    turn_speed: TurnSpeed = 0.8
    """Turning speed, rad/s."""
    arrival: SmallLength = 0.15
    """A way-point is reached within this distance, metres."""


def _kind(generate: Any) -> str | None:
    """Read the kind that a section of settings names, or that the section made of them has."""
    kind = generate.get("kind") if isinstance(generate, dict) else getattr(generate, "kind", None)
    return None if kind is None else str(kind)


Generator = Annotated[
    Annotated[CorridorGenerator, Tag("corridor")]
    | Annotated[CampusGenerator, Tag("campus")]
    | Annotated[OfficeGenerator, Tag("office")]
    | Annotated[LoopGenerator, Tag("loop")],
    Discriminator(_kind),
]
"""``kind`` says which, and which of the settings there are."""


class Scenario(Section):
    """One whole experiment."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    """Name of the scenario, and of its run folders."""
    description: str = ""
    """Description in one line."""
    generate: Generator | None = None
    """Makes a world, a route and people from a seed, when the scenario is loaded; written by hand, they add to it."""
    world: World = World()
    people: tuple[Person, ...] = ()
    """People who walk there."""
    robot: RobotConfig = RobotConfig()
    lidar: LidarConfig = LidarConfig()
    hardware: HardwareConfig = HardwareConfig()
    ros: RosConfig = RosConfig()
    route: Route = Route()
    physics: Physics = Physics()
    slam: SlamConfig = SlamConfig()
    duration: Positive = 600.0
    """The run ends after this many simulated seconds at the latest."""
    seed: int = Field(0, ge=0)
    """Seed of all that is random: values that the file leaves to chance, noise of lidar and wheels, map points."""

    @property
    def path(self) -> list[Point]:
        """The start, then the way-points: the robot drives from one straight to the next; map frame, metres."""
        return [(self.robot.start.x, self.robot.start.y), *self.route.waypoints]

    @property
    def clock(self) -> Clock:
        """Division of time among physics, control and scans."""
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
