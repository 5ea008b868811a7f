"""The base of a Pioneer P3-DX in a simulated world, with the speed ramps, watchdog and encoders of its controller."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, isfinite, pi, sin
from typing import Final

import numpy as np

from sim.bullet import pybullet
from sim.ramp import ramped
from sim.resources import asset
from sim.world import World
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.scenario.robot_config import Limits

WHEEL_RADIUS: Final = 0.0975
"""Of the wheels in p3dx.urdf, metres."""
TRACK: Final = 0.330
"""Between the wheels in p3dx.urdf, metres."""
TICKS_PER_TURN: Final = 76_600
"""Of a wheel: 500 lines, read on 4 edges, behind a 38.3:1 gear; 125 ticks/mm, where the vendor's table says 128."""
WATCHDOG: Final = 2.0
"""Seconds without a command after which ARCOS stops the robot (AMRISim, world.inc)."""
MOTOR_TORQUE: Final = 3.0
"""N m at a wheel: several times what the ramps need, and just too little to make a blocked robot slip or tip over."""


@dataclass(frozen=True, slots=True)
class Ticks:
    """Both wheel encoders, counted from where the robot was put down; forward is positive."""

    left: int
    right: int


class P3dx:
    """Call ``control`` before each step of the world. Frames: base_link lies on the floor under the axle's middle."""

    def __init__(self, world: World, start: Pose2D, limits: Limits) -> None:
        self._world = world
        self._limits = limits
        self._target = self.setpoint = Twist2D()
        self._watchdog_step = 0
        self._body = self._load(start)
        self._wheels = [self._joint(b"left_wheel"), self._joint(b"right_wheel")]
        self._base_com = np.array(world.bullet.call(pybullet.getDynamicsInfo, self._body, -1)[3])
        world.bullet.call(pybullet.changeDynamics, self._body, -1, linearDamping=0.0, angularDamping=0.0)
        self._run_motors()

    def command(self, twist: Twist2D) -> Twist2D:
        """Ask for a velocity; the answer is the one within the limits that the ramps now lead to."""
        if not (isfinite(twist.linear) and isfinite(twist.angular)):
            raise RobotError(f"cannot drive at {twist}: both speeds must be finite numbers")
        v, w = self._limits.linear, self._limits.angular
        self._target = Twist2D(float(np.clip(twist.linear, -v, v)), float(np.clip(twist.angular, -w, w)))
        self._watchdog_step = self._world.steps + round(WATCHDOG * self._world.rate)
        return self._target

    def control(self) -> None:
        """What the controller does in one physics step: watchdog, ramps, motors."""
        if self._world.steps >= self._watchdog_step:
            self._target = Twist2D()
        if self.setpoint != self._target:
            self.setpoint = self._ramped_setpoint()
            self._run_motors()

    @property
    def pose(self) -> Pose2D:
        """The truth, ``T_map_base``."""
        position, quaternion = self._world.bullet.call(pybullet.getBasePositionAndOrientation, self._body)
        R_map_base = np.array(pybullet.getMatrixFromQuaternion(quaternion)).reshape(3, 3)
        x, y, _ = position - R_map_base @ self._base_com  # PyBullet's position is the centre of mass
        return Pose2D(float(x), float(y), float(np.arctan2(R_map_base[1, 0], R_map_base[0, 0])))

    def read_encoders(self) -> Ticks:
        """Where the wheels stand now."""
        left, right = self._world.bullet.call(pybullet.getJointStates, self._body, self._wheels)
        per_radian = TICKS_PER_TURN / (2.0 * pi)
        return Ticks(round(left[0] * per_radian), round(right[0] * per_radian))

    @property
    def collided(self) -> bool:
        """Whether the body touched a wall, box or table in the last step."""
        return self._world.touches_walls(self._body)

    def _ramped_setpoint(self) -> Twist2D:
        limits, rate = self._limits, self._world.rate
        turn = limits.angular_acceleration / rate
        return Twist2D(
            ramped(self.setpoint.linear, self._target.linear, limits.acceleration / rate, limits.deceleration / rate),
            ramped(self.setpoint.angular, self._target.angular, turn, turn),
        )

    def _run_motors(self) -> None:
        v, rim = self.setpoint.linear, self.setpoint.angular * TRACK / 2.0
        self._world.bullet.call(
            pybullet.setJointMotorControlArray,
            self._body,
            self._wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=[(v - rim) / WHEEL_RADIUS, (v + rim) / WHEEL_RADIUS],
            forces=[MOTOR_TORQUE, MOTOR_TORQUE],
        )

    def _load(self, start: Pose2D) -> int:
        body: int = self._world.bullet.call(
            pybullet.loadURDF,
            str(asset("urdf/p3dx.urdf")),
            [start.x, start.y, 0.0],
            [0.0, 0.0, sin(start.theta / 2.0), cos(start.theta / 2.0)],
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE,  # else it is computed anew from the collision shapes
        )
        return body

    def _joint(self, name: bytes) -> int:
        call = self._world.bullet.call
        names = [call(pybullet.getJointInfo, self._body, i)[1] for i in range(call(pybullet.getNumJoints, self._body))]
        return names.index(name)
