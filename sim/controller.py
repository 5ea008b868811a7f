"""The microcontroller on the base: what the firmware knows, and how Python calls it."""

from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.dead_reckoning import reckon, reported_pose, take_mean_twist
from sim.firmware import (
    DRAG_TORQUE,
    MOTOR_TORQUE,
    command,
    control,
    is_stalling,
    set_velocity,
    switch_on,
    update_stall_protection,
    wheel_speeds,
)
from sim.records import ROBOT, model_of
from sim.wheels import TRACK, WHEEL_RADIUS
from slam.compiled import compiled_in_order
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scenario.robot_config import RobotConfig

Joint = tuple[float, float, Any, float]
"""State of a simulated wheel in PyBullet: angle, rad; speed, rad/s; forces; torque of the motor, N m."""


class Controller:
    """Runs the firmware of one robot, at ``config.control_rate``."""

    def __init__(self, config: RobotConfig, physics_rate: int) -> None:
        self._robot: NDArray[Any] = np.zeros(1, ROBOT)
        self._robot["model"] = model_of(config, physics_rate)
        self.base, self.model = self._robot["base"][0], self._robot["model"][0]
        """Records of the state of the firmware, and of its settings."""
        self._motors = self._robot["motors"][0]
        self.restart()

    def restart(self) -> None:
        """Reset the firmware: the robot stands without a command, at time 0."""
        _switch_on(self._robot)
        self._reported_at = 0.0

    def command(self, twist: Twist2D) -> Twist2D:
        """Set the target of the ramps, and return it: the velocity within the limits."""
        if not (isfinite(twist.linear) and isfinite(twist.angular)):
            raise RobotError(f"cannot drive at {twist}: both speeds must be finite numbers")
        return Twist2D(*_command(self._robot, twist.linear, twist.angular))

    def control(self) -> bool:
        """Run the watchdog and the ramps for one control step; return True if ``motors`` changed."""
        return _control(self._robot)

    def set_velocity(self, setpoint: Twist2D) -> bool:
        """Set the setpoint without ramps; return True if ``motors`` changed."""
        return _set_velocity(self._robot, setpoint.linear, setpoint.angular)

    def read_wheels(self, left: Joint, right: Joint) -> bool:
        """End a control step: read the wheels, and update the odometry; return True if ``motors`` changed."""
        return _read_wheels(self._robot, left[0], right[0], left[1], right[1], left[3], right[3])

    @property
    def noise(self) -> FloatArray:
        """The four numbers of ``dead_reckoning.Noise`` for the next ``read_wheels``; the caller writes them."""
        noise: FloatArray = self._robot["noise"][0]
        return noise

    @property
    def motors(self) -> list[float]:
        """Speeds of the left and the right simulated wheel, rad/s, and the largest torque of each motor, N m."""
        motors: list[float] = self._motors.tolist()
        return motors

    @property
    def setpoint(self) -> Twist2D:
        """Velocity that the motors are set to now."""
        return Twist2D(self.base["v"].item(), self.base["omega"].item())

    @property
    def twist(self) -> Twist2D:
        """Velocity of the base at the last ``read_wheels``, from its simulated wheels."""
        return Twist2D.from_wheels(self.base["rim_left"].item(), self.base["rim_right"].item(), TRACK)

    @property
    def ticks(self) -> tuple[int, int]:
        """Count of the left and the right encoder at the last ``read_wheels``, since the reset."""
        return self.base["ticks_left"].item(), self.base["ticks_right"].item()

    @property
    def odometry(self) -> Pose2D:
        """Reported ``T_odom_base``."""
        return Pose2D(*_reported_pose(self._robot))

    def mean_twist(self, time: float) -> Twist2D:
        """Return the reported mean velocity since the last call, at ``time`` seconds."""
        seconds, self._reported_at = time - self._reported_at, time
        return Twist2D(*_take_mean_twist(self._robot, seconds))

    @property
    def stalled(self) -> bool:
        """True if the motors have stalled."""
        return bool(self.base["stalled"])


@compiled_in_order
def _switch_on(robot: NDArray[Any]) -> None:
    switch_on(robot[0].base)
    _tell_motors(robot)


@compiled_in_order
def _command(robot: NDArray[Any], v: float, omega: float) -> tuple[float, float]:
    return command(robot[0].base, robot[0].model, v, omega)


@compiled_in_order
def _control(robot: NDArray[Any]) -> bool:
    return control(robot[0].base, robot[0].model) and _tell_motors(robot)


@compiled_in_order
def _set_velocity(robot: NDArray[Any], v: float, omega: float) -> bool:
    return set_velocity(robot[0].base, v, omega) and _tell_motors(robot)


@compiled_in_order
def _read_wheels(
    robot: NDArray[Any], left: float, right: float, left_speed: float, right_speed: float,
    left_torque: float, right_torque: float,
) -> bool:  # fmt: skip
    base, model, noise = robot[0].base, robot[0].model, robot[0].noise
    base.left, base.right = left, right
    base.rim_left, base.rim_right = WHEEL_RADIUS * left_speed, WHEEL_RADIUS * right_speed
    reckon(base, model, (noise[0], noise[1], noise[2], noise[3]))
    straining = is_stalling(base.rim_left, base.rim_right, left_torque, right_torque)
    return update_stall_protection(base, model, straining) and _tell_motors(robot)


@compiled_in_order
def _tell_motors(robot: NDArray[Any]) -> bool:
    """Write the new setpoint of the motors; return True."""
    base, motors = robot[0].base, robot[0].motors
    motors[0], motors[1] = wheel_speeds(base, robot[0].model)
    motors[2] = MOTOR_TORQUE if base.off_steps == 0 else DRAG_TORQUE
    return True


@compiled_in_order
def _reported_pose(robot: NDArray[Any]) -> tuple[float, float, float]:
    return reported_pose(robot[0].base, robot[0].model)


@compiled_in_order
def _take_mean_twist(robot: NDArray[Any], seconds: float) -> tuple[float, float]:
    return take_mean_twist(robot[0].base, robot[0].model, seconds)
