"""The P3-DX and its sensors in the world of a scenario: what the simulated robot and the emulated devices share."""

import numpy as np

from sim.bumpers import Bumpers
from sim.furniture import Furniture
from sim.lidar import SimulatedLidar
from sim.p3dx import P3dx
from sim.people import People
from sim.sonar import SonarRing
from sim.wheels import WheelOdometry
from sim.world import World
from slam.pose import Pose2D
from slam.scenario.robot_config import RobotConfig
from slam.scenario.schema import Scenario


class RobotInWorld:
    """A PyBullet world of its own, ``rate`` physics steps a second, in which the scenario's robot stands at its start.

    Call ``_begin`` before time passes.
    """

    def __init__(self, scenario: Scenario, robot: RobotConfig, rate: int) -> None:
        movables = scenario.world.movables()
        self._wheel_errors = robot.odometry
        self._world = World(scenario.world.fixed_prisms(), rate)
        self._base = P3dx(self._world, robot)
        self._people = People(self._world, scenario.people)
        self._furniture = Furniture(self._world, movables)
        self._lidar = SimulatedLidar(self._world, scenario.lidar, self._people.leg_radii, movables)
        self._sonar = SonarRing(self._world, movables) if robot.sonar else None

    def _begin(self, seed: int) -> None:
        """Take the noise of this seed, and count the wheels' way and the bumpers from now on."""
        self._lidar_rng, odometry_rng = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(2))
        self._bumpers = Bumpers()
        self._wheels = WheelOdometry(self._wheel_errors, self._base.read_encoders(), odometry_rng)

    def _advance(self, steps: int) -> None:
        """Let so many physics steps pass, which are one control step, then read the encoders."""
        world, base = self._world, self._base
        for _ in range(steps):
            world.step()
            if contacts := base.contacts():
                self._bumpers.add(contacts, base.place)
        self._wheels.add(base.read_encoders())
        if self._people:
            self._people.step(base.place[:2], steps / world.rate)

    def _read_sonar(self, T_map_base: Pose2D) -> tuple[float, ...]:
        """Read the front ring from this pose; () where the scenario has none."""
        if self._sonar is None:
            return ()
        return self._sonar.read(T_map_base, self._people.legs, self._people.leg_radii, self._furniture.places)
