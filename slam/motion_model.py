"""Uncertainty of odometry: the covariance of one motion of the base."""

from math import cos, sin

import numpy as np

from slam.compiled import compiled
from slam.config import LeastSquaresConfig, MotionConfig
from slam.pose import FloatArray, Pose2D

BEYOND = 9.0
"""The model of odometry expects squared corrections of up to this many variances."""


def motion_covariance(motion: Pose2D, heading: float, config: MotionConfig) -> FloatArray:
    """Covariance (3, 3) of x, y, theta in the map frame of a motion that began at ``heading`` (radians) there.

    Standard deviations grow in proportion to the way and to the turn; they are laid along and across the mean heading.
    """
    travelled, turned = motion.distance(Pose2D()), abs(motion.theta)
    along = (config.along * travelled) ** 2 + config.least**2
    across = (config.across * travelled) ** 2 + config.least**2
    turn = (config.turn * turned + config.turn_by_travel * travelled) ** 2 + config.least**2
    c, s = cos(heading + 0.5 * motion.theta), sin(heading + 0.5 * motion.theta)
    cross = c * s * (along - across)
    return np.array(
        [
            [c * c * along + s * s * across, cross, 0.0],
            [cross, s * s * along + c * c * across, 0.0],
            [0.0, 0.0, turn],
        ]
    )


def propagate(covariance: FloatArray, start: Pose2D, end: Pose2D) -> FloatArray:
    """Carry a covariance (3, 3) of a pose from ``start`` to ``end``, the motion between them being certain.

    An error of the heading becomes one of the position.
    """
    return carried(np.ascontiguousarray(covariance), start.y - end.y, end.x - start.x)


@compiled
def carried(covariance: FloatArray, x_by_turn: float, y_by_turn: float) -> FloatArray:
    """Carry a covariance (3, 3) elsewhere: F C F^T for F = [[1, 0, x_by_turn], [0, 1, y_by_turn], [0, 0, 1]]."""
    C = covariance.copy()
    for j in range(3):
        C[0, j] += x_by_turn * C[2, j]
        C[1, j] += y_by_turn * C[2, j]
    for i in range(3):
        C[i, 0] += x_by_turn * C[i, 2]
        C[i, 1] += y_by_turn * C[i, 2]
    return C


def excess_covariance(excess: FloatArray) -> FloatArray:
    """Covariance (3, 3) of the errors of odometry beyond its model, whose variances (2,) are m^2 and rad^2."""
    place, heading = excess
    return np.array([[place, 0.0, 0.0], [0.0, place, 0.0], [0.0, 0.0, heading]])


def updated_excess(
    excess: FloatArray, correction: FloatArray, motion: FloatArray, config: LeastSquaresConfig
) -> FloatArray:
    """The envelope (2,), m^2 and rad^2, of squared corrections (3,) of odometry.

    Only what is beyond three standard deviations of the covariance (3, 3) of the motion counts: it rises at once, fades
    by ``memory``, and never asks for more than the search can look through.

    A factor on the variances does not help where the wheels say nothing: nothing times any factor is nothing. Wheels
    that failed once fail again soon, so that a mean over scans that were good between would be too small.
    """
    dx, dy, turn = correction
    place = 0.5 * (dx * dx + dy * dy) - BEYOND * max(motion[0, 0], motion[1, 1])
    heading = turn * turn - BEYOND * motion[2, 2]
    memory, window, window_angle = config.motion.memory, config.search.window, config.search.window_angle
    return np.array(
        [
            min(max(memory * excess[0], place), (window / 3.0) ** 2),
            min(max(memory * excess[1], heading), (window_angle / 3.0) ** 2),
        ]
    )
