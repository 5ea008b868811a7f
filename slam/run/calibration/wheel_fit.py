"""Wheel radii and track fitted to the motion that the odometry reports and the motion that was true.

The closed form of Censi, Franchi, Marchionni and Oriolo (IEEE T-RO 29, 2013): headings first, which are linear in each
wheel's way over the track, then ways, which are linear in the track.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slam.errors import InputError
from slam.pose import FloatArray, unit_vectors, wrap_angles


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A side or a turn, with the base at rest at both ends: K poses each, (K, 3), x, y in metres and theta in radians.

    ``truth`` may err, and need not begin where ``odometry`` begins; only its two ends count.
    """

    odometry: FloatArray
    truth: FloatArray


@dataclass(frozen=True, slots=True)
class WheelFit:
    """Factors between the wheels and what the odometry takes them for; 1 is no difference.

    ``left`` and ``right`` are the true way of each wheel for each metre reported, ``track`` the true effective distance
    between them for each metre believed.
    """

    left: float = 1.0
    right: float = 1.0
    track: float = 1.0


def wheel_travels(odometry: FloatArray, track: float) -> tuple[FloatArray, FloatArray]:
    """Ways of the left and the right wheel between K poses (K, 3), metres, (K - 1,): eqs. (38)-(42) backwards."""
    turns = wrap_angles(np.diff(odometry[:, 2]))
    headings = odometry[:-1, 2] + turns / 2.0
    steps = np.diff(odometry[:, :2], axis=0)
    chords = steps[:, 0] * np.cos(headings) + steps[:, 1] * np.sin(headings)
    ways = chords / np.sinc(turns / (2.0 * np.pi))
    return ways - turns * track / 2.0, ways + turns * track / 2.0


def corrected(odometry: FloatArray, track: float, fit: WheelFit) -> FloatArray:
    """The same K poses (K, 3) as wheels of this fit make them, from the first one on."""
    left, right = wheel_travels(odometry, track)
    return dead_reckoned(odometry[0], fit.left * left, fit.right * right, track * fit.track)


def dead_reckoned(start: FloatArray, left: FloatArray, right: FloatArray, track: float) -> FloatArray:
    """Poses (K, 3) from ``start`` (3,) on, with the wheels' ways (K - 1,) between them: eqs. (38)-(44)."""
    turns = (right - left) / track
    headings = start[2] + np.concatenate([[0.0], np.cumsum(turns)])
    chords = (left + right) / 2.0 * np.sinc(turns / (2.0 * np.pi))
    middles = headings[:-1] + turns / 2.0
    steps = chords[:, None] * unit_vectors(middles)
    return np.column_stack([start[:2] + np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)]), headings])


def fit_wheels(legs: Sequence[Leg], track: float) -> WheelFit:
    """Least squares over all legs; ``track`` is what the odometry believes, metres.

    InputError where the drive does not tell: it needs both straight ways and turns.
    """
    ways = [wheel_travels(leg.odometry, track) for leg in legs]
    totals = np.array([(-left.sum(), right.sum()) for left, right in ways]).reshape(-1, 2)
    believed = np.array([wrap_angles(np.diff(leg.odometry[:, 2])).sum() for leg in legs])  # may be over half a turn
    turned = believed + wrap_angles(np.array([leg.truth[-1, 2] - leg.truth[0, 2] for leg in legs]) - believed)
    if np.linalg.matrix_rank(totals, tol=0.1) < 2:
        raise InputError("the wheels cannot be told from this drive; it needs straight ways and turns")
    per_track = np.linalg.lstsq(totals, turned, rcond=None)[0]  # of each wheel's way, radians a metre
    of_unit_track = [dead_reckoned(np.zeros(3), per_track[0] * left, per_track[1] * right, 1.0) for left, right in ways]
    unit = np.concatenate([displacement(poses) for poses in of_unit_track])
    true = np.concatenate([displacement(leg.truth) for leg in legs])
    metres = float(unit @ true / (unit @ unit))  # the true effective track
    return WheelFit(float(per_track[0]) * metres, float(per_track[1]) * metres, metres / track)


def fit_errors(squares: Sequence[Sequence[Leg]], track: float) -> WheelFit:
    """Standard errors of the results of ``fit_wheels`` from all these squares' legs.

    They are by the jackknife, one square left out each time. What errs in all squares alike, such as the scale of a
    map, shows in part only.
    """
    n = len(squares)
    rests = [[leg for square in [*squares[:k], *squares[k + 1 :]] for leg in square] for k in range(n)]
    found = np.array([(fit.left, fit.right, fit.track) for fit in (fit_wheels(rest, track) for rest in rests)])
    return WheelFit(*np.sqrt((n - 1) * found.var(axis=0)).tolist())


def displacement(poses: FloatArray) -> FloatArray:
    """X and y of the last pose in the frame of the first."""
    (dx, dy), theta = poses[-1, :2] - poses[0, :2], poses[0, 2]
    return np.array([np.cos(theta) * dx + np.sin(theta) * dy, np.cos(theta) * dy - np.sin(theta) * dx])
