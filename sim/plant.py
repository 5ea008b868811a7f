"""The world that moves emulated devices: the simulated base and lidar without the simulated firmware."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from sim.rays import ScanMotion
from sim.robot_in_world import RobotInWorld
from slam.errors import ScenarioError
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.scenario.schema import Scenario

_RATE: Final = 100
"""Turns a second of the emulated firmware's loop: how often ``advance`` is called."""


class SimPlant(RobotInWorld):
    """A ``Plant`` for the emulator: the scenario's world, people, wheels and noise in PyBullet.

    Ramps, limits and the watchdog are the emulated firmware's, which rounds its own reports too. Time passes in whole
    physics steps: the rate is the scenario's, or the next multiple of 100 a second.
    """

    def __init__(self, scenario: Scenario) -> None:
        if not scenario.world.prisms():
            raise ScenarioError(f"{scenario.name}: nothing to see: the world is empty; choose a scenario with walls")
        errors = scenario.robot.odometry.model_copy(update={"firmware_units": False})
        robot = scenario.robot.model_copy(update={"control_rate": _RATE, "odometry": errors})
        super().__init__(scenario, robot, -(-scenario.physics.rate // _RATE) * _RATE)
        self._begin(scenario.seed)
        self._left = self._right = 0.0
        still = self._sweep([self._place()] * 2, 1.0)  # compiled now: later, real time does not wait for it
        self._lidar.measure_beams(np.zeros(1), still, 0.0, 0.0, np.random.default_rng(0))

    @property
    def T_map_base(self) -> Pose2D:
        """The truth."""
        return self._base.pose

    @property
    def elapsed(self) -> float:
        """Seconds that have passed."""
        return self._world.time

    @property
    def odometry(self) -> Pose2D:
        """``T_odom_base`` from the wheels, in the frame where the base was put down."""
        return self._wheels.pose

    @property
    def travel(self) -> tuple[float, float]:
        """Metres that the left and the right wheel have rolled, as the encoders say."""
        return self._left, self._right

    @property
    def stalled(self) -> bool:
        """True while the motors have stalled."""
        return self._base.stalled

    def advance(self, seconds: float, setpoint: Twist2D) -> None:
        """Let time pass with the motors at this speed."""
        self._base.set_velocity(setpoint)
        self._advance(round(seconds * self._world.rate))
        left, right = self._wheels.mean_twist(self._world.time).to_wheels(self._wheel_errors.track)
        self._left += left * seconds
        self._right += right * seconds

    def ranges(self, bearings: FloatArray, ahead: float = 0.0, increment: float = 0.0) -> FloatArray:
        """Ranges that the lidar reports along these directions (N,) of its own frame, with its noise.

        The first beam fires ``ahead`` seconds from now, the others ``increment`` seconds after one another; the base
        moves at the speed of now.
        """
        seconds = len(bearings) * increment
        sweep = self._sweep([self._place(ahead), self._place(ahead + seconds)], seconds or 1.0)
        return self._lidar.measure_beams(bearings, sweep, increment, self._world.time, self._lidar_rng)

    def bumpers(self) -> tuple[bool, ...]:
        """Bumper segments pressed since the last call: front, then rear, each from left to right."""
        return self._bumpers.read()[1]

    def sonar(self) -> tuple[float, ...]:
        """The front ring, metres from left to right, inf without an echo; () where the scenario has none."""
        return self._read_sonar(self._base.pose)

    def _sweep(self, path: Sequence[Pose2D], seconds: float) -> ScanMotion:
        """Sweep from one place of the base to another, with all else where it is now."""
        people, things = np.array([self._people.legs] * 2), np.array([self._furniture.places] * 2)
        return ScanMotion(stack_poses(path), people, seconds, things)

    def _place(self, ahead: float = 0.0) -> Pose2D:
        """Predict the pose of the base so many seconds ahead, at its present speed."""
        return self._base.pose @ self._base.twist.motion(ahead)
