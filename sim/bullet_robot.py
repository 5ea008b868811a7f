"""The robot in a PyBullet world: wheels, walls, people and furniture with contact forces."""

import numpy as np

from sim.bumpers import Bumpers
from sim.furniture import Furniture
from sim.p3dx import P3dx
from sim.people import People
from sim.rays import ScanMotion
from sim.robot_in_world import RobotInWorld
from sim.world import World
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scenario.robot_config import RobotConfig
from slam.scenario.schema import Scenario


class BulletRobot(RobotInWorld):
    """A robot in its own PyBullet world, with ``rate`` physics steps per second."""

    def __init__(self, scenario: Scenario, robot: RobotConfig, rate: int) -> None:
        movables = scenario.world.movables()
        self._world = World(scenario.world.fixed_prisms(), rate)
        self._base = P3dx(self._world, robot)
        self._people = People(self._world, scenario.people)
        self._furniture = Furniture(self._world, movables)
        super().__init__(scenario, robot, rate, self._base.controller, self._world, self._people.leg_radii, movables)
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
        self._base.restart(np.random.default_rng(odometry_seed))
        self._people.restart()
        self._bumpers = Bumpers()

    def advance(self, controls: int) -> None:
        for _ in range(controls):
            self._base.control()
            self._step()

    def sweep(self, controls: int) -> ScanMotion:
        path, rows = [], controls + 1
        legs, things = np.empty((rows, 2 * len(self._people), 2)), np.empty((rows, len(self._furniture), 3))
        for k in range(rows):
            if k > 0:
                self._base.control()
                self._step()
            path.append(self._base.place)
            if legs.size:
                legs[k] = self._people.legs
            if things.size:
                things[k] = self._furniture.places
        return ScanMotion(np.array(path), legs, self._steps_per_control / self._rate, things)

    def roll(self, setpoint: Twist2D, controls: int) -> None:
        self._base.set_velocity(setpoint)
        for _ in range(controls):
            self._step()

    @property
    def pose(self) -> Pose2D:
        return self._base.pose

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
        """Run one control step, then read the wheels."""
        base, step, near = self._base, self._world.step, self._base.near
        for _ in range(self._steps_per_control):
            step()
            if (found := near()) and (contacts := base.contacts(found)):
                self._bumpers.add(contacts, base.place)
        self.steps += self._steps_per_control
        base.read_wheels()
        if self._leg_radii.size:
            self._people.step(base.place[:2], self._steps_per_control / self._rate)
