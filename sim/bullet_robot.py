"""The robot in a PyBullet world: wheels, walls, people and furniture that meet with forces."""

import numpy as np

from sim.bumpers import Bumpers
from sim.furniture import Furniture
from sim.p3dx import P3dx
from sim.people import People
from sim.rays import ScanMotion
from sim.robot_in_world import RobotInWorld
from sim.wheels import WheelOdometry
from sim.world import World
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scenario.robot_config import RobotConfig
from slam.scenario.schema import Scenario


class BulletRobot(RobotInWorld):
    """A robot in its own PyBullet world, with ``rate`` physics steps per second."""

    def __init__(self, scenario: Scenario, robot: RobotConfig, rate: int) -> None:
        movables = scenario.world.movables()
        self._wheel_errors = robot.odometry
        self._steps_per_control = rate // robot.control_rate
        self._world = World(scenario.world.fixed_prisms(), rate)
        self._base = P3dx(self._world, robot)
        self._people = People(self._world, scenario.people)
        self._furniture = Furniture(self._world, movables)
        super().__init__(scenario, robot, self._world, self._people.leg_radii, movables)
        self._world.save()

    def close(self) -> None:
        self._world.close()

    @property
    def closed(self) -> bool:
        return self._world.closed

    def _restart(self, odometry_seed: np.random.SeedSequence) -> None:
        self._furniture.park_far_away()
        self._base.park_far_away()
        self._world.restore()
        self._base.restart()
        self._people.restart()
        self._bumpers = Bumpers()
        rng = np.random.default_rng(odometry_seed)
        self._wheels = WheelOdometry(self._wheel_errors, self._base.read_encoders(), rng)

    @property
    def steps(self) -> int:
        return self._world.steps

    @property
    def time(self) -> float:
        return self._world.time

    def command(self, twist: Twist2D) -> Twist2D:
        return self._base.command(twist)

    def advance(self, controls: int) -> None:
        for _ in range(controls):
            self._base.control()
            self._step()

    def sweep(self, controls: int) -> ScanMotion:
        path, legs, things = [self._base.place], [self._people.legs], [self._furniture.places]
        for _ in range(controls):
            self._base.control()
            self._step()
            path.append(self._base.place)
            legs.append(self._people.legs)
            things.append(self._furniture.places)
        period = self._steps_per_control / self._world.rate
        return ScanMotion(np.array(path), np.array(legs), period, np.array(things))

    def roll(self, setpoint: Twist2D, controls: int) -> None:
        self._base.set_velocity(setpoint)
        for _ in range(controls):
            self._step()

    @property
    def pose(self) -> Pose2D:
        return self._base.pose

    @property
    def twist(self) -> Twist2D:
        return self._base.twist

    @property
    def odometry(self) -> Pose2D:
        return self._wheels.pose

    def mean_twist(self) -> Twist2D:
        return self._wheels.mean_twist(self._world.time)

    @property
    def stalled(self) -> bool:
        return self._base.stalled

    def read_bumpers(self) -> tuple[bool, tuple[bool, ...]]:
        return self._bumpers.read()

    @property
    def people(self) -> FloatArray:
        return self._people.positions

    @property
    def legs(self) -> FloatArray:
        return self._people.legs

    @property
    def furniture(self) -> FloatArray:
        return self._furniture.places

    def _step(self) -> None:
        """Run one control step, then read the encoders."""
        world, base = self._world, self._base
        for _ in range(self._steps_per_control):
            world.step()
            if contacts := base.contacts():
                self._bumpers.add(contacts, base.place)
        self._wheels.add(base.read_encoders())
        if self._people:
            self._people.step(base.place[:2], self._steps_per_control / world.rate)
