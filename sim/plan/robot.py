"""The robot as a kinematic model in the plan of its world, which needs no PyBullet."""

from collections.abc import Sequence

import numpy as np

from sim.bumpers import segments_of
from sim.controller import Controller
from sim.crowd import crowd_of
from sim.plan.advance import advance, walk
from sim.plan.base import put_down
from sim.plan.footprint import RADIUS
from sim.ray_casters import ExactCaster, RayCaster
from sim.rays import ScanMotion
from sim.robot_in_world import RobotInWorld
from sim.wall_plan import wall_plan
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
        controller = Controller(robot, rate)
        self._base, self._model = controller.base, controller.model
        self._obstacles = wall_plan([obstacle_footprints(prisms)], RADIUS)
        self._crowd = crowd_of([scenario.people])
        self._walked = np.zeros((len(scenario.people), 2))
        self._positions = np.zeros((len(scenario.people), 2))
        self._legs = np.zeros((len(scenario.people), 2, 2))
        self.closed = False
        super().__init__(scenario, robot, rate, controller, PlanWorld(prisms), self._crowd.leg_radii[0], ())

    closed = False

    def close(self) -> None:
        self.closed = True

    def _restart(self, odometry_seed: np.random.SeedSequence) -> None:
        start = self._start
        self.controller.restart()
        put_down(self._base, start.x, start.y, start.theta, odometry_seed.generate_state(1, np.uint64)[0])
        self._walked[:, 0], self._walked[:, 1] = self._crowd.starts[0], 0.0
        walk(self._base, self._crowd, 0, 0.0, self._walked, self._positions, self._legs)

    def advance(self, controls: int) -> None:
        self._pass(controls, True)

    def sweep(self, controls: int) -> ScanMotion:
        path, legs = self._pass(controls, True)
        return ScanMotion(path, legs, self._steps_per_control / self._rate)

    def roll(self, setpoint: Twist2D, controls: int) -> None:
        self.controller.set_velocity(setpoint)
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

    def read_bumpers(self) -> tuple[bool, tuple[bool, ...]]:
        collided, pressed = bool(self._base["collided"]), int(self._base["bumpers"])
        self._base["collided"] = self._base["bumpers"] = 0
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
