"""The base of a Pioneer P3-DX in a simulated world, with the speed ramps, watchdog and encoders of its controller."""

from math import atan2, cos, isfinite, sin

from sim.bullet import pybullet
from sim.bumpers import TOUCH, Contact
from sim.firmware import DRAG_TORQUE, MOTOR_TORQUE, WATCHDOG, StallGuard, ramped
from sim.wheels import TICKS_PER_RADIAN, TRACK, WHEEL_RADIUS, Pair, Ticks, TractionModel
from sim.world import World
from slam.assets import P3DX_URDF, asset
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.scenario.robot_config import RobotConfig


class P3dx:
    """The base in the engine, with its motors.

    Call ``control`` before every control step, ``control_rate`` times a second. Frames: base_link lies on the floor
    under the axle's middle.
    """

    def __init__(self, world: World, config: RobotConfig) -> None:
        self._world = world
        self._config = config
        self._traction = TractionModel(config.traction)
        self._body = self._load(config.start.pose)
        self._wheels = [self._joint(b"left_wheel"), self._joint(b"right_wheel")]
        self._find_contacts = world.bullet.prepared(pybullet.getContactPoints, self._body, linkIndexA=-1)
        self._find_joints = world.bullet.prepared(pybullet.getJointStates, self._body, self._wheels)
        self._find_base = world.bullet.prepared(pybullet.getBasePositionAndOrientation, self._body)
        self._rolling = [0.0, 0.0]  # rad/s, of the simulated wheels
        self._torques = [MOTOR_TORQUE, MOTOR_TORQUE]  # N m, the largest
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
        self.restart()

    def park_far_away(self) -> None:
        """Move far from everything.

        The engine then forgets the robot's neighbours, which ``World.restore`` does not undo, and which decide the
        order in which contacts are solved.
        """
        self._world.park_far_away(self._body, 0)
        self._world.bullet.call(pybullet.performCollisionDetection)

    def restart(self) -> None:
        """Stop, without a command, for a world that was restored to its start."""
        self._target = self.setpoint = Twist2D()
        self._watchdog_step = 0
        self._rims = 0.0, 0.0  # m/s, of the simulated wheels
        self._guard = StallGuard(self._config.control_rate)
        self._torques[:] = MOTOR_TORQUE, MOTOR_TORQUE
        self._run_motors()

    def command(self, twist: Twist2D) -> Twist2D:
        """Command a velocity; return it clipped to the limits, which the ramps now approach."""
        if not (isfinite(twist.linear) and isfinite(twist.angular)):
            raise RobotError(f"cannot drive at {twist}: both speeds must be finite numbers")
        limits = self._config.limits
        v, w = limits.linear, limits.angular
        self._target = Twist2D(min(max(twist.linear, -v), v), min(max(twist.angular, -w), w))
        self._watchdog_step = self._world.steps + round(WATCHDOG * self._world.rate)
        return self._target

    def control(self) -> None:
        """Run one control step of the firmware: watchdog, ramps, motors."""
        if self._world.steps >= self._watchdog_step:
            self._target = Twist2D()
        if self._guard.engaged and self.setpoint != self._target:
            self.setpoint = self._ramped_setpoint()
            self._run_motors()

    def set_velocity(self, setpoint: Twist2D) -> None:
        """Turn the wheels at this speed from now on, for a firmware with its own limits, ramps and watchdog."""
        if self._guard.engaged and setpoint != self.setpoint:
            self.setpoint = setpoint
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

    def read_encoders(self) -> Ticks:
        """Present encoder counts of both wheels."""
        (left, left_speed, _, left_torque), (right, right_speed, _, right_torque) = self._find_joints()
        self._rims = WHEEL_RADIUS * left_speed, WHEEL_RADIUS * right_speed
        self._watch((left_torque, right_torque))
        angles = self._traction.to_robot(left, right)
        return Ticks(round(angles[0] * TICKS_PER_RADIAN), round(angles[1] * TICKS_PER_RADIAN))

    @property
    def twist(self) -> Twist2D:
        """Velocity of the base at the last reading of the encoders, computed from its simulated wheels."""
        return Twist2D.from_wheels(*self._rims, TRACK)

    @property
    def stalled(self) -> bool:
        """True while the motors are stalled at the last reading of the encoders: see ``StallGuard``."""
        return self._guard.stalled

    def contacts(self) -> list[Contact]:
        """Return the points where the body touched anything but the floor in the last physics step."""
        if not (found := self._find_contacts()):
            return []
        floor, movables = self._world.floor, self._world.movables
        touching = (c for c in found if c[2] != floor and c[8] < TOUCH)
        return [Contact(c[5][0], c[5][1], c[2] in movables) for c in touching]

    def _ramped_setpoint(self) -> Twist2D:
        limits, rate = self._config.limits, self._config.control_rate
        turn = limits.angular_acceleration / rate
        return Twist2D(
            ramped(self.setpoint.linear, self._target.linear, limits.acceleration / rate, limits.deceleration / rate),
            ramped(self.setpoint.angular, self._target.angular, turn, turn),
        )

    def _watch(self, torques: Pair) -> None:
        """Cut the motors, or power them again, as the guard decides; the ramps then begin at rest."""
        engaged = self._guard.engaged
        self._guard.watch(self._rims, torques, MOTOR_TORQUE)
        if self._guard.engaged != engaged:
            self.setpoint = Twist2D()
            self._torques[:] = (DRAG_TORQUE, DRAG_TORQUE) if engaged else (MOTOR_TORQUE, MOTOR_TORQUE)
            self._run_motors()

    def _run_motors(self) -> None:
        """Turn the wheels at the speeds that the firmware computes for the setpoint."""
        believed = self._config.odometry
        left, right = self.setpoint.to_wheels(believed.track)
        self._rolling[:] = self._traction.to_simulated(left / believed.left_radius, right / believed.right_radius)
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
