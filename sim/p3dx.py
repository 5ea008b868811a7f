"""The body of a Pioneer P3-DX in a PyBullet world, with the motors that its controller runs."""

from collections.abc import Callable, Iterable
from math import atan2, cos, sin
from typing import Any

import numpy as np

from sim.bullet import pybullet
from sim.bumpers import TOUCH, Contact
from sim.controller import Controller
from sim.world import World
from slam.assets import P3DX_URDF, asset
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.scenario.robot_config import RobotConfig


class P3dx:
    """The base in the engine.

    Call ``control`` before every control step, ``control_rate`` times a second. Frames: base_link lies on the floor
    under the axle's middle.
    """

    def __init__(self, world: World, config: RobotConfig) -> None:
        self._world = world
        self.controller = Controller(config, world.rate)
        errors = config.odometry
        self._noise = self.controller.noise[0 if errors.encoder_noise else 2 : 4 if errors.travel_noise else 2]
        self._body = self._load(config.start.pose)
        self._wheels = [self._joint(b"left_wheel"), self._joint(b"right_wheel")]
        self.near: Callable[[], tuple[Any, ...]]
        self.near = world.bullet.prepared(pybullet.getContactPoints, self._body, linkIndexA=-1)
        """Function that returns PyBullet's contact points of the body in the last physics step, also those near it."""
        self._find_joints = world.bullet.prepared(pybullet.getJointStates, self._body, self._wheels)
        self._find_base = world.bullet.prepared(pybullet.getBasePositionAndOrientation, self._body)
        self._rolling = [0.0, 0.0]  # rad/s, of the simulated wheels
        self._torques = [0.0, 0.0]  # N m, the largest
        self._set_motors = world.bullet.prepared(
            pybullet.setJointMotorControlArray,
            self._body,
            self._wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=self._rolling,
            forces=self._torques,
        )
        self._com_x, _, self._com_z = world.bullet.call(pybullet.getDynamicsInfo, self._body, -1)[3]
        world.bullet.call(pybullet.changeDynamics, self._body, -1, linearDamping=0.0, angularDamping=0.0)
        for wheel in self._wheels:
            world.bullet.call(pybullet.changeDynamics, self._body, wheel, lateralFriction=config.traction.friction)
        self.restart(np.random.default_rng(0))

    def park_far_away(self) -> None:
        """Move far from everything.

        The engine then forgets which bodies were near the robot. ``World.restore`` does not reset this list, and its
        order decides the order in which contacts are solved.
        """
        self._world.park_far_away(self._body, 0)
        self._world.bullet.call(pybullet.performCollisionDetection)

    def restart(self, rng: np.random.Generator) -> None:
        """Reset the controller after the world was restored to its start; ``rng`` draws the wheel errors."""
        self._rng = rng
        self.controller.restart()
        self._run_motors()

    def control(self) -> None:
        """Let the controller turn the wheels as its ramps say; before every control step."""
        if self.controller.control():
            self._run_motors()

    def set_velocity(self, setpoint: Twist2D) -> None:
        """Turn the wheels at this speed from now on, for a firmware with its own limits, ramps and watchdog."""
        if self.controller.set_velocity(setpoint):
            self._run_motors()

    def read_wheels(self) -> None:
        """Let the controller read the wheels, which may have stalled; called after each control step."""
        left, right = self._find_joints()
        if len(self._noise):
            self._rng.standard_normal(out=self._noise)
        if self.controller.read_wheels(left, right):
            self._run_motors()

    @property
    def place(self) -> tuple[float, float, float]:
        """True pose ``T_map_base`` as x, y, theta; theta in [-pi, pi]."""
        (px, py, _), (qx, qy, qz, qw) = self._find_base()
        xx, xy = 1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy + qz * qw)  # the base's x axis in the map
        zx, zy = 2.0 * (qx * qz + qy * qw), 2.0 * (qy * qz - qx * qw)  # the base's z axis in the map
        x = px - self._com_x * xx - self._com_z * zx  # PyBullet's position is the centre of mass, which has y = 0
        y = py - self._com_x * xy - self._com_z * zy
        return x, y, atan2(xy, xx)

    @property
    def pose(self) -> Pose2D:
        """True pose ``T_map_base``."""
        return Pose2D(*self.place)

    def contacts(self, near: Iterable[Any]) -> list[Contact]:
        """Return the contacts among ``near`` in which the body touched anything but the floor."""
        floor, movables = self._world.floor, self._world.movables
        touching = (c for c in near if c[2] != floor and c[8] < TOUCH)
        return [Contact(c[5][0], c[5][1], c[2] in movables) for c in touching]

    def _run_motors(self) -> None:
        """Tell the motors what the controller says."""
        self._rolling[0], self._rolling[1], torque = self.controller.motors
        self._torques[:] = torque, torque
        self._set_motors()

    def _load(self, start: Pose2D) -> int:
        body: int = self._world.bullet.call(
            pybullet.loadURDF,
            str(asset(P3DX_URDF)),
            [start.x, start.y, 0.0],
            [0.0, 0.0, sin(start.theta / 2.0), cos(start.theta / 2.0)],
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE,  # otherwise it is recomputed from the collision shapes
        )
        return body

    def _joint(self, name: bytes) -> int:
        call = self._world.bullet.call
        names = [call(pybullet.getJointInfo, self._body, i)[1] for i in range(call(pybullet.getNumJoints, self._body))]
        return names.index(name)
