"""A scenario: a world, a robot in it, where it goes, and the method that maps it. Read from YAML."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from slam.config import Section, SlamConfig
from slam.lidars import LidarModel, lidar_model
from slam.pose import Pose2D
from slam.run.scenario.world_plan import Point, World

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]


class Place(Section):
    """A pose in the plane, metres and radians."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    @property
    def pose(self) -> Pose2D:
        """As a value to compute with."""
        return Pose2D(self.x, self.y, self.theta)


class WheelErrors(Section):
    """What is wrong with the wheel odometry. The robot itself has wheels of 0.0975 m radius, 0.330 m apart."""

    left_radius: Positive = 0.0975
    """Radius that the odometry believes of the left wheel, metres."""
    right_radius: Positive = 0.0975
    """The same of the right wheel, metres."""
    track: Positive = 0.330
    """Distance between the wheels that the odometry believes, metres."""
    travel_noise: NotNegative = 0.0
    """Random error of each wheel's travel: its standard deviation after one metre, metres (grows with the root)."""


class Limits(Section):
    """What the base obeys, as an ARCOS robot does."""

    linear: Positive = 1.2
    """Speed, m/s."""
    angular: Positive = 5.236
    """Turning speed, rad/s."""
    acceleration: Positive = 0.3
    """m/s^2."""
    deceleration: Positive = 0.6
    """m/s^2."""
    angular_acceleration: Positive = 1.74
    """rad/s^2."""


class RobotConfig(Section):
    """The Pioneer P3-DX."""

    start: Place = Place()
    """Where the base stands at first, map frame."""
    odometry: WheelErrors = WheelErrors()
    limits: Limits = Limits()


class LidarConfig(Section):
    """The lidar on the robot."""

    model: Literal["table1", "urg04lx"] = "urg04lx"
    mount: Place = Place(x=0.16)
    """Where it sits on the base: ``T_base_laser``."""
    height: Positive = 0.30
    """Of the scan plane above the floor, metres."""
    noise: Literal["table1", "none"] = "table1"
    """``table1``: Gaussian, as in the paper's Table 1."""
    bound_sigmas: Positive = 3.0
    """How many standard deviations the maker's plus-minus bound is. The paper does not say; 3 is the usual reading."""
    dropout: float = Field(0.0, ge=0, le=1)
    """Share of beams that get no echo for no reason."""

    @property
    def description(self) -> LidarModel:
        """The sensor of that name."""
        return lidar_model(self.model)


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
    robot: RobotConfig = RobotConfig()
    lidar: LidarConfig = LidarConfig()
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
