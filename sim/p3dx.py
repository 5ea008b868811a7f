"""The base of a Pioneer P3-DX in a simulated world, with the speed ramps, watchdog and encoders of its controller."""

from __future__ import annotations

from math import atan2, cos, isfinite, pi, sin
from typing import Final, NamedTuple

from sim.bullet import pybullet
from sim.ramp import ramped
from sim.resources import asset
from sim.traction import Grip
from sim.world import TOUCH, World
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.scenario.robot_config import RobotConfig

WHEEL_RADIUS: Final = 0.0975
"""Of the wheels in p3dx.urdf, metres."""
TICKS_PER_TURN: Final = 76_600
"""Of a wheel: 500 lines, read on 4 edges, behind a 38.3:1 gear; 125 ticks/mm, where the vendor's table says 128."""
TICKS_PER_RADIAN: Final = TICKS_PER_TURN / (2.0 * pi)
WATCHDOG: Final = 2.0
"""Seconds without a command after which ARCOS stops the robot (AMRISim, world.inc)."""
FAR_AWAY: Final = (1e4, 1e4, 5.0)
"""x, y, z, metres: nothing is there."""
MOTOR_TORQUE: Final = 2.4
"""N m at a wheel: several times what the ramps need, and too little to make the wheels of a blocked robot spin."""
STALL_TIME: Final = 0.5
"""Seconds of full torque after which a wheel counts as stalled. ARCOS has such a time in its StallCount; ours."""


Contact = tuple[float, float]
"""x and y of where the body was touched, map frame."""


class Ticks(NamedTuple):
    """Both wheel encoders, counted from where the robot was put down; forward is positive."""

    left: int
    right: int


class P3dx:
    """Call ``control`` before every control step, that is ``control_rate`` times a second.

    Frames: base_link lies on the floor under the axle's middle.
    """

    def __init__(self, world: World, config: RobotConfig) -> None:
        self._world = world
        self._config = config
        self._grip = Grip(config.traction)
        self._body = self._load(config.start.pose)
        self._wheels = [self._joint(b"left_wheel"), self._joint(b"right_wheel")]
        self._find_contacts = world.bullet.prepared(pybullet.getContactPoints, self._body, linkIndexA=-1)
        self._find_joints = world.bullet.prepared(pybullet.getJointStates, self._body, self._wheels)
        self._find_base = world.bullet.prepared(pybullet.getBasePositionAndOrientation, self._body)
        self._rolling = [0.0, 0.0]  # rad/s, of the simulated wheels
        self._set_motors = world.bullet.prepared(
            pybullet.setJointMotorControlArray,
            self._body,
            self._wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=self._rolling,
            forces=[MOTOR_TORQUE, MOTOR_TORQUE],
        )
        self._com_x, _, self._com_z = world.bullet.call(pybullet.getDynamicsInfo, self._body, -1)[3]
        world.bullet.call(pybullet.changeDynamics, self._body, -1, linearDamping=0.0, angularDamping=0.0)
        self.restart()

    def leave(self) -> None:
        """Stand far from everything: the engine then forgets what the robot was near, which ``World.restore`` does not
        undo, and in whose order contacts are solved."""
        self._world.bullet.call(pybullet.resetBasePositionAndOrientation, self._body, FAR_AWAY, (0.0, 0.0, 0.0, 1.0))
        self._world.bullet.call(pybullet.performCollisionDetection)

    def restart(self) -> None:
        """At rest, with no command: for a world that is back at its start."""
        self._target = self.setpoint = Twist2D()
        self._watchdog_step = 0
        self._blocked = [0, 0]  # control steps at full torque, of either wheel
        self._run_motors()

    def command(self, twist: Twist2D) -> Twist2D:
        """Ask for a velocity; the answer is the one within the limits that the ramps now lead to."""
        if not (isfinite(twist.linear) and isfinite(twist.angular)):
            raise RobotError(f"cannot drive at {twist}: both speeds must be finite numbers")
        limits = self._config.limits
        v, w = limits.linear, limits.angular
        self._target = Twist2D(min(max(twist.linear, -v), v), min(max(twist.angular, -w), w))
        self._watchdog_step = self._world.steps + round(WATCHDOG * self._world.rate)
        return self._target

    def control(self) -> None:
        """What the controller does in one control step: watchdog, ramps, motors."""
        if self._world.steps >= self._watchdog_step:
            self._target = Twist2D()
        if self.setpoint != self._target:
            self.setpoint = self._ramped_setpoint()
            self._run_motors()

    def turn(self, setpoint: Twist2D) -> None:
        """Turn the wheels at this speed from now on: for a firmware with limits, ramps and a watchdog of its own."""
        if setpoint != self.setpoint:
            self.setpoint = setpoint
            self._run_motors()

    @property
    def place(self) -> tuple[float, float, float]:
        """The truth, ``T_map_base``, as x, y, theta; theta in [-pi, pi]."""
        (px, py, _), (qx, qy, qz, qw) = self._find_base()
        xx, xy = 1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy + qz * qw)  # the base's x axis in the map
        zx, zy = 2.0 * (qx * qz + qy * qw), 2.0 * (qy * qz - qx * qw)  # and its z axis
        x = px - self._com_x * xx - self._com_z * zx  # PyBullet's position is the centre of mass, which has y = 0
        y = py - self._com_x * xy - self._com_z * zy
        return x, y, atan2(xy, xx)

    @property
    def pose(self) -> Pose2D:
        """The truth, ``T_map_base``."""
        return Pose2D(*self.place)

    def read_encoders(self) -> Ticks:
        """Where the wheels stand now."""
        left, right = self._find_joints()
        for wheel, torque in enumerate((left[3], right[3])):
            self._blocked[wheel] = self._blocked[wheel] + 1 if abs(torque) > 0.99 * MOTOR_TORQUE else 0
        angles = self._grip.turned(left[0], right[0])
        return Ticks(round(angles[0] * TICKS_PER_RADIAN), round(angles[1] * TICKS_PER_RADIAN))

    @property
    def stalled(self) -> bool:
        """Whether a motor has pushed with all its torque for STALL_TIME, as the last readings of the encoders say."""
        return max(self._blocked) >= STALL_TIME * self._config.control_rate

    def contacts(self) -> list[Contact]:
        """Where the body touched anything but the floor in the last physics step."""
        found = self._find_contacts()
        return [c[5][:2] for c in found if c[2] != self._world.floor and c[8] < TOUCH] if found else []

    def _ramped_setpoint(self) -> Twist2D:
        limits, rate = self._config.limits, self._config.control_rate
        turn = limits.angular_acceleration / rate
        return Twist2D(
            ramped(self.setpoint.linear, self._target.linear, limits.acceleration / rate, limits.deceleration / rate),
            ramped(self.setpoint.angular, self._target.angular, turn, turn),
        )

    def _run_motors(self) -> None:
        """Turn the wheels as the firmware believes that the setpoint needs."""
        believed = self._config.odometry
        v, rim = self.setpoint.linear, self.setpoint.angular * believed.track / 2.0
        self._rolling[:] = self._grip.rolled((v - rim) / believed.left_radius, (v + rim) / believed.right_radius)
        self._set_motors()

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
