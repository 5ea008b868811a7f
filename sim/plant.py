"""The world that moves emulated devices: the simulated base and lidar without the simulated firmware."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from sim.rays import ScanMotion
from sim.robot_in_world import robot_in_world
from slam.errors import ScenarioError
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.scenario.schema import Scenario

_RATE: Final = 100
"""Frequency, Hz, of the emulated firmware's loop, which calls ``advance``."""


def plan_plant(scenario: Scenario) -> "SimPlant":
    """Make the plant of this scenario without PyBullet."""
    return SimPlant(scenario.model_copy(update={"physics": scenario.physics.model_copy(update={"engine": "plan"})}))


class SimPlant:
    """A ``Plant`` for the emulator: the scenario's world, people, wheels and noise, in its ``physics.engine``.

    Ramps, limits and the watchdog are the emulated firmware's, which rounds its own reports too. Time passes in whole
    physics steps: the rate is the scenario's, or the next multiple of 100 a second.
    """

    def __init__(self, scenario: Scenario) -> None:
        if not scenario.world.prisms():
            raise ScenarioError(f"{scenario.name}: nothing to see: the world is empty; choose a scenario with walls")
        errors = scenario.robot.odometry.model_copy(update={"firmware_units": False})
        robot = scenario.robot.model_copy(update={"control_rate": _RATE, "odometry": errors})
        self._track = errors.track
        self._body = robot_in_world(scenario, robot, -(-scenario.physics.rate // _RATE) * _RATE)
        self._left = self._right = 0.0
        self._compile(scenario.seed)
        self._body.restart(scenario.seed)

    @property
    def T_map_base(self) -> Pose2D:
        """True pose of the base in the map frame."""
        return self._body.pose

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return self._body.time

    @property
    def odometry(self) -> Pose2D:
        """``T_odom_base`` from the wheels, in the frame of the start."""
        return self._body.odometry

    @property
    def travel(self) -> tuple[float, float]:
        """Metres that the left and the right wheel have rolled, by the encoders."""
        return self._left, self._right

    @property
    def stalled(self) -> bool:
        """True while the motors have stalled."""
        return self._body.stalled

    def advance(self, seconds: float, setpoint: Twist2D) -> None:
        """Let time pass with the motors at this speed."""
        controls = round(seconds * _RATE)
        self._body.roll(setpoint, controls)
        left, right = self._body.mean_twist().to_wheels(self._track)
        self._left += left * controls / _RATE
        self._right += right * controls / _RATE

    def ranges(self, bearings: FloatArray, ahead: float = 0.0, increment: float = 0.0) -> FloatArray:
        """Ranges that the lidar reports along these directions (N,) of its own frame, with its noise.

        The first beam fires ``ahead`` seconds from now, the others ``increment`` seconds apart; the base keeps its
        present speed.
        """
        seconds = len(bearings) * increment
        sweep = self._sweep([self._place(ahead), self._place(ahead + seconds)], seconds or 1.0)
        return self._body.lidar.measure_beams(bearings, sweep, increment, self._body.time, self._body.lidar_rng)

    def bumpers(self) -> tuple[bool, ...]:
        """Bumper segments pressed since the last call: front, then rear, each from left to right."""
        return self._body.read_bumpers()[1]

    def sonar(self) -> tuple[float, ...]:
        """The front ring, metres from left to right, inf without an echo; () where the scenario has none."""
        return self._body.read_sonar()

    def _compile(self, seed: int) -> None:
        """Call every compiled function once, so that the emulator never waits for the compiler."""
        self._body.restart(seed)
        self._body.roll(Twist2D(), 1)
        self._body.mean_twist()
        still = self._sweep([self._place()] * 2, 1.0)
        self._body.lidar.measure_beams(np.zeros(1), still, 0.0, 0.0, np.random.default_rng(0))

    def _sweep(self, path: Sequence[Pose2D], seconds: float) -> ScanMotion:
        """Return the motion from one pose of the base to another, with everything else at its present position."""
        people, things = np.array([self._body.legs] * 2), np.array([self._body.furniture] * 2)
        return ScanMotion(stack_poses(path), people, seconds, things)

    def _place(self, ahead: float = 0.0) -> Pose2D:
        """Predict the pose of the base ``ahead`` seconds later, at its present speed."""
        return self._body.pose @ self._body.twist.motion(ahead)
