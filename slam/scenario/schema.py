"""A scenario: a world, a robot in it with a route, and the SLAM method. Read from YAML."""

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
    """Way-points, map frame, metres; an empty list: the robot stands still. The default in a generated world is a tour
    of it."""
    speed: Speed = 0.5
    """Speed, m/s."""
    turn_speed: TurnSpeed = 0.8
    """Turning speed, rad/s."""
    arrival: SmallLength = 0.15
    """Distance at which a way-point counts as reached, metres."""


def _kind(generate: Any) -> str | None:
    """Return the kind of generator in its settings, or in the section made of them."""
    kind = generate.get("kind") if isinstance(generate, dict) else getattr(generate, "kind", None)
    return None if kind is None else str(kind)


Generator = Annotated[
    Annotated[CorridorGenerator, Tag("corridor")]
    | Annotated[CampusGenerator, Tag("campus")]
    | Annotated[OfficeGenerator, Tag("office")]
    | Annotated[LoopGenerator, Tag("loop")],
    Discriminator(_kind),
]
"""A generator of worlds with its settings; ``kind`` selects it."""


class Scenario(Section):
    """One whole experiment."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    """Name of the scenario, and of its run folders."""
    description: str = ""
    """Description in one line."""
    generate: Generator | None = None
    """Generator of a world, a route and people from a seed, at the time of loading; it adds to those in the file."""
    world: World = World()
    people: tuple[Person, ...] = ()
    """People who walk in the world."""
    robot: RobotConfig = RobotConfig()
    lidar: LidarConfig = LidarConfig()
    hardware: HardwareConfig = HardwareConfig()
    ros: RosConfig = RosConfig()
    route: Route = Route()
    physics: Physics = Physics()
    slam: SlamConfig = SlamConfig()
    duration: Positive = 600.0
    """Longest simulated time of the run, seconds."""
    seed: int = Field(0, ge=0)
    """Seed of all random numbers: random values in the file, noise of lidar and wheels, map points."""

    @property
    def path(self) -> list[Point]:
        """Start and way-points, map frame, metres; the robot drives straight from one to the next."""
        return [(self.robot.start.x, self.robot.start.y), *self.route.waypoints]

    @property
    def clock(self) -> Clock:
        """Clocks of physics, control and scans."""
        lidar = self.lidar.description.lidar
        sweep = (lidar.beams - 1) * self.lidar.time_increment
        return make_clock(self.physics.rate, self.robot.control_rate, lidar.scan_time, sweep)

    @model_validator(mode="after")
    def _has_valid_times(self) -> Self:
        scan_time = self.lidar.description.lidar.scan_time
        if self.duration < scan_time:
            raise ValueError(f"duration = {self.duration:g} s ends before the first scan, which takes {scan_time:g} s")
        _ = self.clock
        return self
