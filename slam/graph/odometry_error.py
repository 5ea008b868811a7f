"""Errors of the wheels, learnt from motions that scans measured; before that, the front end uses a guess.

In a corridor only odometry measures its length. With the guess, which is large enough for unknown wheels, every loop
would stretch the corridor.
"""

from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from slam.graph.key_scan import KeyScan
from slam.pose import FloatArray, relative_poses, wrap_angles

MIN_STEPS: Final = 10
"""Least number of motions to learn from."""
GUESS: Final = 0.2, 0.1, 0.1
"""Assumed standard deviations along, across, and of the heading, per metre, until enough motions are known."""
MIN_SIGMAS: Final = 0.01, 0.01, 0.005
"""Lower bounds of these standard deviations."""
METRES_PER_RADIAN: Final = 0.5
"""Metres that a turn of one radian counts as."""
MIN_LENGTH: Final = 0.05
"""Shortest motion to learn from, metres."""
FLOOR: Final = np.array([0.003, 0.003, 0.002])
"""Least standard deviations of any motion, metres and radians."""
SURE: Final = 1e4
"""Information along a direction, m^-2, above which the scan is more accurate than the wheels."""
TO_SIGMA: Final = 1.4826
"""From the median of the absolute errors to the standard deviation of a normal distribution."""


class OdometryError(NamedTuple):
    """Standard deviations per metre: along, across (m), heading (rad)."""

    sigmas: FloatArray
    """(3,)."""

    @classmethod
    def learnt(cls, keys: list[KeyScan], follows: NDArray[np.bool_]) -> Self:
        """Learn from the motions to key scans by the wheels and by matching; robust against wrong matches.

        The mask (K,) is True for key scans that follow the previous one in the list.
        """
        wheels = np.array([key.wheel_motion for key in keys]).reshape(-1, 3)
        errors, lengths = motion_errors(keys, follows), lengths_of(wheels)
        known = np.array([is_sure(key) for key in keys], np.bool_) & (lengths > MIN_LENGTH) & follows
        if known.sum() < MIN_STEPS:
            return cls(np.array(GUESS))
        return cls(np.maximum(TO_SIGMA * np.median(np.abs(errors[known]) / lengths[known, None], axis=0), MIN_SIGMAS))

    def covariance(self, wheels: FloatArray, error: FloatArray) -> FloatArray:
        """Return the covariance (3, 3) of one motion (3,), in the axes of its start.

        A known contradiction by the scan, ``error`` (3,), increases it accordingly.
        """
        sigmas = self.sigmas * lengths_of(wheels)
        along, across, turn = sigmas**2 + error**2 + FLOOR**2
        heading = np.arctan2(wheels[1], wheels[0]) if np.hypot(wheels[0], wheels[1]) > 1e-6 else 0.0
        c, s = np.cos(heading), np.sin(heading)
        cross = c * s * (along - across)
        return np.array(
            [
                [c * c * along + s * s * across, cross, 0.0],
                [cross, s * s * along + c * c * across, 0.0],
                [0.0, 0.0, turn],
            ]
        )


def lengths_of(motions: FloatArray) -> FloatArray:
    """Return the lengths of motions (..., 3), metres, including turns."""
    return np.asarray(np.hypot(motions[..., 0], motions[..., 1]) + METRES_PER_RADIAN * np.abs(motions[..., 2]))


def motion_errors(keys: list[KeyScan], follows: NDArray[np.bool_]) -> FloatArray:
    """Return the motion to each key scan by the wheels minus that by matching, (K, 3): along, across, turn.

    It is zero for a key scan that does not follow the previous one, by the mask ``follows`` (K,).
    """
    local = np.array([key.T_local_laser for key in keys]).reshape(-1, 3)
    wheels = np.array([key.wheel_motion for key in keys]).reshape(-1, 3)
    errors = np.zeros_like(wheels)
    moved = relative_poses(local[:-1], local[1:])
    off, turn = wheels[1:] - moved, np.arctan2(wheels[1:, 1], wheels[1:, 0])
    c, s = np.cos(turn), np.sin(turn)
    errors[1:, 0], errors[1:, 1] = c * off[:, 0] + s * off[:, 1], c * off[:, 1] - s * off[:, 0]
    errors[1:, 2] = wrap_angles(off[:, 2])
    errors[~follows] = 0.0
    return errors


def is_sure(key: KeyScan) -> bool:
    """Return True if the scan constrained the pose in every direction."""
    return not key.broken and float(np.linalg.eigvalsh(key.information[:2, :2])[0]) > SURE
