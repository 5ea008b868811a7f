"""Errors of the wheels, learnt from where scans told the motion: the front end only has a guess.

In a corridor odometry alone says how long it is. What the guess allows it to err, made for wheels that nobody has
measured, would let every loop stretch the corridor.
"""

from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from slam.graph.key_scan import KeyScan
from slam.pose import FloatArray, relative_poses, wrap_angles

LEAST_STEPS: Final = 10
"""Motions that must be known before anything is learnt from them."""
GUESS: Final = 0.2, 0.1, 0.1
"""Until then: standard deviations along, across, and of the heading, all for every metre ..."""
LEAST: Final = 0.01, 0.01, 0.005
"""... and what they are at least."""
TURN_WAY: Final = 0.5
"""Metres that a turn of one radian counts as."""
LEAST_WAY: Final = 0.05
"""Metres: of shorter motions nothing is learnt."""
FLOOR: Final = np.array([0.003, 0.003, 0.002])
"""Metres and radians: least standard deviations of any motion."""
SURE: Final = 1e4
"""m^-2: information along a direction, above which the scan knows the motion better than the wheels."""
TO_SIGMA: Final = 1.4826
"""From the median of the absolute errors to the standard deviation of a normal distribution."""


class OdometryError(NamedTuple):
    """Standard deviations for every metre: along, across (m), heading (rad)."""

    sigmas: FloatArray
    """(3,)."""

    @classmethod
    def learnt(cls, keys: list[KeyScan], follows: NDArray[np.bool_]) -> Self:
        """Learn from the motions to key scans by the wheels and as matched; robust against those that went wrong.

        The mask (K,) is True for key scans that follow the one before them in the list.
        """
        wheels = np.array([key.wheels for key in keys]).reshape(-1, 3)
        errors, way = motion_errors(keys, follows), way_of(wheels)
        known = np.array([is_sure(key) for key in keys], np.bool_) & (way > LEAST_WAY) & follows
        if known.sum() < LEAST_STEPS:
            return cls(np.array(GUESS))
        return cls(np.maximum(TO_SIGMA * np.median(np.abs(errors[known]) / way[known, None], axis=0), LEAST))

    def covariance(self, wheels: FloatArray, error: FloatArray) -> FloatArray:
        """Covariance (3, 3) of one motion (3,), in the axes of its start.

        Where the scan is known to contradict it, by the ``error`` (3,), it is trusted by so much less.
        """
        sigmas = self.sigmas * way_of(wheels)
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


def way_of(motions: FloatArray) -> FloatArray:
    """Metres of motions (..., 3), turns counted in."""
    return np.asarray(np.hypot(motions[..., 0], motions[..., 1]) + TURN_WAY * np.abs(motions[..., 2]))


def motion_errors(keys: list[KeyScan], follows: NDArray[np.bool_]) -> FloatArray:
    """Motion to each key scan by the wheels less that by matching, (K, 3): along, across, turned.

    Zero where it does not follow the one before, mask (K,).
    """
    local = np.array([key.T_local_laser for key in keys]).reshape(-1, 3)
    wheels = np.array([key.wheels for key in keys]).reshape(-1, 3)
    errors = np.zeros_like(wheels)
    moved = relative_poses(local[:-1], local[1:])
    off, turn = wheels[1:] - moved, np.arctan2(wheels[1:, 1], wheels[1:, 0])
    c, s = np.cos(turn), np.sin(turn)
    errors[1:, 0], errors[1:, 1] = c * off[:, 0] + s * off[:, 1], c * off[:, 1] - s * off[:, 0]
    errors[1:, 2] = wrap_angles(off[:, 2])
    errors[~follows] = 0.0
    return errors


def is_sure(key: KeyScan) -> bool:
    """True where the scan knew the place in every direction."""
    return not key.broken and float(np.linalg.eigvalsh(key.information[:2, :2])[0]) > SURE
