"""The robot as a kinematic model in the plan of its world, which needs no PyBullet."""

from collections.abc import Sequence
from math import isfinite

import numpy as np

from sim.bumpers import segments_of
from sim.crowd import crowd_of
from sim.plan.advance import advance, walk
from sim.plan.base import command, put_down
from sim.plan.footprint import RADIUS
from sim.plan.records import BASE, model_of
from sim.plan.reports import reported_pose, take_mean_twist
from sim.ray_casters import ExactCaster, RayCaster
from sim.rays import ScanMotion
from sim.robot_in_world import RobotInWorld
from sim.wall_plan import wall_plan
from sim.wheels import TRACK
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scenario.lidar_config import CasterName
from slam.scenario.robot_config import RobotConfig
from slam.scenario.schema import Scenario
from slam.scenario.solids import Prism, obstacle_footprints


class PlanWorld:
    """Solids that the lidar and the sonar see in their plan."""

    def __init__(self, prisms: Sequence[Prism]) -> None:
        self._prisms = prisms

    def caster(self, name: CasterName, height: float, reach: float) -> RayCaster:
        """Make an exact ray caster, whatever the name: there is no mesh."""
        return ExactCaster(self._prisms, height, reach)


class PlanRobot(RobotInWorld):
    """A robot in the plan; it cannot push anything: it stops at an obstacle, and stalls while it tries to move on."""

    def __init__(self, scenario: Scenario, robot: RobotConfig, rate: int) -> None:
        prisms = scenario.world.prisms()
        self._start = robot.start.pose
        self._rate, self._steps_per_control = rate, rate // robot.control_rate
        self._base, self._model = np.zeros(1, BASE)[0], model_of(robot, rate)[0]
        self._obstacles = wall_plan([obstacle_footprints(prisms)], RADIUS)
        self._crowd = crowd_of([scenario.people])
        self._walked = np.zeros((len(scenario.people), 2))
        self._positions = np.zeros((len(scenario.people), 2))
        self._legs = np.zeros((len(scenario.people), 2, 2))
        self.closed = False
        super().__init__(scenario, robot, PlanWorld(prisms), self._crowd.leg_radii[0], ())

    closed = False

    def close(self) -> None:
        self.closed = True

    def _restart(self, odometry_seed: np.random.SeedSequence) -> None:
        start = self._start
        put_down(self._base, start.x, start.y, start.theta, odometry_seed.generate_state(1, np.uint64)[0])
        self.steps = self._reported_at = 0
        self._walked[:, 0], self._walked[:, 1] = self._crowd.starts[0], 0.0
        walk(self._base, self._crowd, 0, 0.0, self._walked, self._positions, self._legs)

    steps = 0

    @property
    def time(self) -> float:
        return self.steps / self._rate

    def command(self, twist: Twist2D) -> Twist2D:
        if not (isfinite(twist.linear) and isfinite(twist.angular)):
            raise RobotError(f"cannot drive at {twist}: both speeds must be finite numbers")
        command(self._base, self._model, twist.linear, twist.angular)
        return Twist2D(float(self._base["target_v"]), float(self._base["target_omega"]))

    def advance(self, controls: int) -> None:
        self._pass(controls, True)

    def sweep(self, controls: int) -> ScanMotion:
        path, legs = self._pass(controls, True)
        return ScanMotion(path, legs, self._steps_per_control / self._rate)

    def roll(self, setpoint: Twist2D, controls: int) -> None:
        if self._base["cut_for"] == 0:
            self._base["v"], self._base["omega"] = setpoint.linear, setpoint.angular
        self._pass(controls, False)

    def _pass(self, controls: int, ramps: bool) -> tuple[FloatArray, FloatArray]:
        path, legs = np.empty((controls + 1, 3)), np.empty((controls + 1, 2 * len(self._walked), 2))
        advance(
            self._base, self._model, ramps, self._obstacles, self._crowd, 0,
            self._walked, self._positions, self._legs, path, legs,
        )  # fmt: skip
        self.steps += controls * self._steps_per_control
        return path, legs

    @property
    def pose(self) -> Pose2D:
        return Pose2D(*self._base[["x", "y", "theta"]].item())

    @property
    def twist(self) -> Twist2D:
        return Twist2D.from_wheels(float(self._base["rim_left"]), float(self._base["rim_right"]), TRACK)

    @property
    def odometry(self) -> Pose2D:
        return Pose2D(*reported_pose(self._base, self._model))

    def mean_twist(self) -> Twist2D:
        seconds = (self.steps - self._reported_at) / self._rate
        self._reported_at = self.steps
        return Twist2D(*take_mean_twist(self._base, self._model, seconds))

    @property
    def stalled(self) -> bool:
        return bool(self._base["stalled"])

    def read_bumpers(self) -> tuple[bool, tuple[bool, ...]]:
        collided, pressed = bool(self._base["collided"]), int(self._base["pressed"])
        self._base["collided"] = self._base["pressed"] = 0
        return collided, segments_of(pressed)

    @property
    def people(self) -> FloatArray:
        return self._positions

    @property
    def legs(self) -> FloatArray:
        return self._legs.reshape(-1, 2).copy()

    @property
    def furniture(self) -> FloatArray:
        return np.empty((0, 3))
