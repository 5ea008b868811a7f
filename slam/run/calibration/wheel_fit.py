"""Wheel radii and track fitted to the motion that the odometry reports and the motion that was true.

The closed form of Censi, Franchi, Marchionni and Oriolo (IEEE T-RO 29, 2013): first the headings, which are linear in
the ratio of each wheel's distance to the track, then the positions, which are linear in the track.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slam.errors import InputError
from slam.pose import FloatArray, unit_vectors, wrap_angles


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A side or a turn, with the base at rest at both ends: K poses each, (K, 3), x, y in metres and theta in radians.

    ``truth`` may have errors, and need not begin at ``odometry``'s first pose; only its two ends count.
    """

    odometry: FloatArray
    truth: FloatArray


@dataclass(frozen=True, slots=True)
class WheelFit:
    """Factors between the real wheels and those that the odometry assumes; 1 means no difference.

    ``left`` and ``right`` are the true distance of each wheel per metre reported, ``track`` the true effective track
    per metre assumed.
    """

    left: float = 1.0
    right: float = 1.0
    track: float = 1.0


def wheel_travels(odometry: FloatArray, track: float) -> tuple[FloatArray, FloatArray]:
    """Return the wheel distances between K poses (K, 3), left and right, (K - 1,), metres: eqs. (38)-(42) inverted."""
    turns = wrap_angles(np.diff(odometry[:, 2]))
    headings = odometry[:-1, 2] + turns / 2.0
    steps = np.diff(odometry[:, :2], axis=0)
    chords = steps[:, 0] * np.cos(headings) + steps[:, 1] * np.sin(headings)
    distances = chords / np.sinc(turns / (2.0 * np.pi))
    return distances - turns * track / 2.0, distances + turns * track / 2.0


def corrected(odometry: FloatArray, track: float, fit: WheelFit) -> FloatArray:
    """Return the same K poses (K, 3) for wheels with this fit, starting at the first one."""
    left, right = wheel_travels(odometry, track)
    return dead_reckoned(odometry[0], fit.left * left, fit.right * right, track * fit.track)


def dead_reckoned(start: FloatArray, left: FloatArray, right: FloatArray, track: float) -> FloatArray:
    """Return the poses (K, 3) from ``start`` (3,), with these distances (K - 1,) of the wheels: eqs. (38)-(44)."""
    turns = (right - left) / track
    headings = start[2] + np.concatenate([[0.0], np.cumsum(turns)])
    chords = (left + right) / 2.0 * np.sinc(turns / (2.0 * np.pi))
    middles = headings[:-1] + turns / 2.0
    steps = chords[:, None] * unit_vectors(middles)
    return np.column_stack([start[:2] + np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)]), headings])


def fit_wheels(legs: Sequence[Leg], track: float) -> WheelFit:
    """Fit by least squares over all legs; ``track`` is the one that the odometry assumes, metres.

    InputError if the drive is not sufficient: it needs both straight legs and turns.
    """
    distances = [wheel_travels(leg.odometry, track) for leg in legs]
    totals = np.array([(-left.sum(), right.sum()) for left, right in distances]).reshape(-1, 2)
    believed = np.array(
        [wrap_angles(np.diff(leg.odometry[:, 2])).sum() for leg in legs]
    )  # total turns; more than half a turn is possible
    turned = believed + wrap_angles(np.array([leg.truth[-1, 2] - leg.truth[0, 2] for leg in legs]) - believed)
    if np.linalg.matrix_rank(totals, tol=0.1) < 2:
        raise InputError("this drive does not determine the wheels; it needs straight legs and turns")
    per_track = np.linalg.lstsq(totals, turned, rcond=None)[0]  # radians of turning per metre of each wheel
    of_unit_track = [
        dead_reckoned(np.zeros(3), per_track[0] * left, per_track[1] * right, 1.0) for left, right in distances
    ]
    unit = np.concatenate([displacement(poses) for poses in of_unit_track])
    true = np.concatenate([displacement(leg.truth) for leg in legs])
    metres = float(unit @ true / (unit @ unit))  # the true effective track
    return WheelFit(float(per_track[0]) * metres, float(per_track[1]) * metres, metres / track)


def fit_errors(squares: Sequence[Sequence[Leg]], track: float) -> WheelFit:
    """Return the standard errors of ``fit_wheels`` on the legs of all these squares.

    They are jackknife errors, with one square left out each time. An error common to all squares, such as the scale of
    a map, is mostly not included.
    """
    n = len(squares)
    rests = [[leg for square in [*squares[:k], *squares[k + 1 :]] for leg in square] for k in range(n)]
    found = np.array([(fit.left, fit.right, fit.track) for fit in (fit_wheels(rest, track) for rest in rests)])
    return WheelFit(*np.sqrt((n - 1) * found.var(axis=0)).tolist())


def displacement(poses: FloatArray) -> FloatArray:
    """Return x and y of the last pose in the frame of the first."""
    (dx, dy), theta = poses[-1, :2] - poses[0, :2], poses[0, 2]
    return np.array([np.cos(theta) * dx + np.sin(theta) * dy, np.cos(theta) * dy - np.sin(theta) * dx])
