"""Uncertainty of odometry: the covariance of one motion of the base."""

from math import cos, sin

import numpy as np

from slam.compiled import compiled
from slam.config import LeastSquaresConfig, MotionConfig
from slam.pose import FloatArray, Pose2D

BEYOND = 9.0
"""The model explains squared corrections of odometry up to this multiple of its predicted variance: three sigma."""


def motion_covariance(motion: Pose2D, heading: float, config: MotionConfig) -> FloatArray:
    """Return the covariance (3, 3) of x, y, theta in the map frame for a motion that began at ``heading`` (radians).

    Standard deviations are proportional to distance and turn, along and across the mean heading.
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
    """Transform a covariance (3, 3) of a pose from ``start`` to ``end``, with an exact motion between them.

    An error of the heading becomes one of the position.
    """
    return carried(np.ascontiguousarray(covariance), start.y - end.y, end.x - start.x)


@compiled
def carried(covariance: FloatArray, x_by_turn: float, y_by_turn: float) -> FloatArray:
    """Return F C F^T (3, 3) for F = [[1, 0, x_by_turn], [0, 1, y_by_turn], [0, 0, 1]]."""
    C = covariance.copy()
    for j in range(3):
        C[0, j] += x_by_turn * C[2, j]
        C[1, j] += y_by_turn * C[2, j]
    for i in range(3):
        C[i, 0] += x_by_turn * C[i, 2]
        C[i, 1] += y_by_turn * C[i, 2]
    return C


def excess_covariance(excess: FloatArray) -> FloatArray:
    """Return the covariance (3, 3) of odometry errors beyond the model, with variances (2,) in m^2 and rad^2."""
    place, heading = excess
    return np.array([[place, 0.0, 0.0], [0.0, place, 0.0], [0.0, 0.0, heading]])


def updated_excess(
    excess: FloatArray, correction: FloatArray, motion: FloatArray, config: LeastSquaresConfig
) -> FloatArray:
    """Return the new excess (2,), m^2 and rad^2: by how much squared corrections of odometry exceeded its model.

    A ``correction`` (3,) counts only beyond three standard deviations of the covariance ``motion`` (3, 3). The excess
    rises to it at once, decays by ``memory``, and stays within the search window.

    It is a variance to add, and not a factor on the predicted one, which is zero if the wheels report no motion. It is
    not a mean either, which would be too small: wheels that failed once fail again soon, with good scans in between.
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
