"""The P3-DX and its sensors in the world of a scenario, for the simulated robot and the emulated devices."""

import logging
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cache
from typing import Final

import numpy as np

from sim.controller import Controller
from sim.lidar import SimulatedLidar
from sim.ray_casters import Surroundings
from sim.rays import ScanMotion
from sim.sonar import SonarRing
from slam.named_code import import_by_name
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scenario.furniture import Movable
from slam.scenario.robot_config import RobotConfig
from slam.scenario.schema import Scenario

_LOG: Final = logging.getLogger("hopslam.sim")
ENGINES: Final = {"bullet": "sim.bullet_robot:BulletRobot", "plan": "sim.plan.robot:PlanRobot"}
"""Classes of ``RobotInWorld`` by the name of ``physics.engine``, imported when they are used."""


def robot_in_world(scenario: Scenario, robot: RobotConfig, rate: int) -> "RobotInWorld":
    """Put this robot into the scenario's world; ``rate`` physics steps per second, a multiple of its control rate."""
    if scenario.physics.engine == "plan" and "engine" not in scenario.physics.model_fields_set:
        _say_what_is_missing()
    made: RobotInWorld = import_by_name(ENGINES[scenario.physics.engine])(scenario, robot, rate)
    return made


@cache
def _say_what_is_missing() -> None:
    """Warn, once per process, that PyBullet is missing."""
    _LOG.warning("PyBullet is not installed: the robot is moved by the kinematic model, physics.engine: plan")


class RobotInWorld(ABC):
    """A robot in its own world, at its start. Call ``restart`` before time passes.

    The same seed and commands give the same results, bit by bit.
    """

    def __init__(
        self,
        scenario: Scenario,
        robot: RobotConfig,
        rate: int,
        controller: Controller,
        surroundings: Surroundings,
        leg_radii: FloatArray,
        movables: Sequence[Movable],
    ) -> None:
        self._rate, self._steps_per_control = rate, rate // robot.control_rate
        self.controller = controller
        """Its firmware, which is the same in every world."""
        self.lidar = SimulatedLidar(surroundings, scenario.lidar, leg_radii, movables)
        self._leg_radii = leg_radii
        self._sonar = SonarRing(surroundings, movables) if robot.sonar else None

    @abstractmethod
    def close(self) -> None:
        """Free all resources; closing twice is allowed."""

    @property
    @abstractmethod
    def closed(self) -> bool:
        """True after ``close``."""

    def restart(self, seed: int) -> None:
        """Return to the start at time 0, at rest, with the noise of this seed."""
        lidar_seed, odometry_seed = np.random.SeedSequence(seed).spawn(2)
        self.lidar_rng = np.random.default_rng(lidar_seed)
        self.steps = 0
        """Physics steps since the start."""
        self._restart(odometry_seed)

    @abstractmethod
    def _restart(self, odometry_seed: np.random.SeedSequence) -> None: ...

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self.steps / self._rate

    def command(self, twist: Twist2D) -> Twist2D:
        """Command a velocity, and return it clipped to the limits; from now on the ramps approach the clipped one."""
        return self.controller.command(twist)

    @abstractmethod
    def advance(self, controls: int) -> None:
        """Run this number of control steps."""

    @abstractmethod
    def sweep(self, controls: int) -> ScanMotion:
        """Run this number of control steps.

        Return the motion of base and legs: a row for the beginning, and one after each control step.
        """

    @abstractmethod
    def roll(self, setpoint: Twist2D, controls: int) -> None:
        """Run this number of control steps with the motors at this speed, for a firmware with its own ramps."""

    @property
    @abstractmethod
    def pose(self) -> Pose2D:
        """True pose ``T_map_base``."""

    @property
    def twist(self) -> Twist2D:
        """True velocity of the base."""
        return self.controller.twist

    @property
    def odometry(self) -> Pose2D:
        """``T_odom_base`` as reported."""
        return self.controller.odometry

    def mean_twist(self) -> Twist2D:
        """Return the mean velocity since the last call, as reported."""
        return self.controller.mean_twist(self.time)

    @property
    def stalled(self) -> bool:
        """True while the motors are stalled."""
        return self.controller.stalled

    @abstractmethod
    def read_bumpers(self) -> tuple[bool, tuple[bool, ...]]:
        """Return whether the robot hit anything fixed since the last reading, and the pressed bumper segments."""

    @property
    @abstractmethod
    def people(self) -> FloatArray:
        """Positions of people, (P, 2)."""

    @property
    @abstractmethod
    def legs(self) -> FloatArray:
        """Middles of all legs, (2 P, 2)."""

    @property
    @abstractmethod
    def furniture(self) -> FloatArray:
        """Poses of the furniture that can be pushed: x, y, theta, (M, 3)."""

    def read_sonar(self) -> tuple[float, ...]:
        """Read the front sonar ring; () if the scenario has none."""
        if self._sonar is None:
            return ()
        return self._sonar.read(self.pose, self.legs, self._leg_radii, self.furniture)
