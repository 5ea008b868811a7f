"""Commands, scans and odometry as the arrays of a gymnasium environment, and the spaces of these arrays."""

from typing import Any, Final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.errors import InputError
from slam.lidars import Lidar
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray
from slam.scan import LaserScan

_BOUND: Final = np.array([1e4, 1e4, np.pi, 10.0, 100.0], np.float32)
"""Largest x, y (m), theta (rad), v (m/s), omega (rad/s) for any robot of this kind."""


def scan_space(lidar: Lidar) -> Box:
    """Ranges (beams,), metres, within [0, range_max]."""
    return Box(0.0, lidar.range_max, (lidar.beams,), np.float32)


def scan_array(scan: LaserScan, lidar: Lidar) -> NDArray[np.float32]:
    """Resample the ranges to the fan of ``lidar``: each beam is the nearest one of the scan.

    No echo, an error, and a bearing without a beam read ``range_max``, too close reads 0.
    """
    reach = lidar.range_max
    ranges = np.where(scan.ranges < reach, scan.ranges, reach)  # comparisons with nan and inf are False
    if (scan.angle_min, scan.angle_increment, len(ranges)) != (lidar.angle_min, lidar.angle_increment, lidar.beams):
        ranges = np.append(ranges, reach)[nearest_beams(scan.lidar, lidar)]
    return np.clip(ranges.astype(np.float32), np.float32(0.0), np.float32(reach))


def nearest_beams(measured: Lidar, nominal: Lidar) -> NDArray[np.int64]:
    """For each beam of ``nominal`` return the index of the nearest one of ``measured``, (beams,).

    A beam beyond both ends of the measured scan, by more than a step of either lidar, has the number of measured beams
    as its index.
    """
    step, turn = measured.angle_increment, 2.0 * np.pi
    ahead = (nominal.angles - measured.angle_min) % turn
    places = np.rint(ahead / step).astype(np.int64)
    places[turn - ahead < 0.5 * step] = 0  # just before the first beam, or a full turn later
    reach = max(step, nominal.angle_increment)
    beyond = places >= measured.beams
    near = np.minimum(np.abs(ahead - (measured.beams - 1) * step), turn - ahead) < reach
    last = np.where(turn - ahead < np.abs(ahead - (measured.beams - 1) * step), 0, measured.beams - 1)
    return np.where(beyond, np.where(near, last, measured.beams), places)


def odometry_space() -> Box:
    """x, y (m), theta (rad), v (m/s), omega (rad/s): wide enough for any robot of this kind."""
    return Box(-_BOUND, _BOUND, dtype=np.float32)


def odometry_array(odometry: Odometry) -> NDArray[np.float32]:
    """Pose and twist in one array, shape (5,)."""
    pose, twist = odometry.T_odom_base, odometry.twist
    return np.clip(np.array([*pose.as_array(), twist.linear, twist.angular], np.float32), -_BOUND, _BOUND)


def action_space() -> Box:
    """Both numbers within -1 and 1: m/s and rad/s, or m/s at the rims of the wheels, without scaling."""
    return Box(-1.0, 1.0, (2,), np.float32)


def twist_action(action: Any) -> Twist2D:
    """Convert forward and turning velocity, (v, omega), to a command."""
    linear, angular = _two_numbers(action, "(v, omega)")
    return Twist2D(float(linear), float(angular))


def wheels_action(action: Any, track: float) -> Twist2D:
    """Convert speeds of the left and the right wheel at their rims, m/s, to a command.

    They are ``track`` metres apart.
    """
    left, right = _two_numbers(action, "(left, right)")
    return Twist2D.from_wheels(float(left), float(right), track)


def _two_numbers(action: Any, meaning: str) -> FloatArray:
    try:
        numbers = np.asarray(action, np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"an action is {meaning}, two numbers; {action!r} is not") from error
    if numbers.shape != (2,):
        raise InputError(f"an action is {meaning}, of shape (2,); this one has shape {numbers.shape}")
    if not np.isfinite(numbers).all():
        raise InputError(f"an action is {meaning}, finite numbers; this is {numbers.tolist()}: did learning diverge?")
    return numbers
