"""The beams of a lidar in the order in which they turn counter-clockwise."""

from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from hopslam.arguments import FULL_TURN
from slam.errors import InputError
from slam.lines.segments import IntArray
from slam.pose import FloatArray, unit_vectors, wrap_angles
from slam.scan import even_fan

_EVEN: Final = 1e-6
"""Radians: angles that differ from even steps by less count as even."""


class Beams(NamedTuple):
    """Order and spacing of N beams; the arrays must not be written to."""

    order: IntArray
    """(N,): index of each beam in the angles that were given."""
    first: float
    """Bearing of the first beam, radians."""
    step: float
    """Mean angle between two beams, radians."""
    fan: FloatArray | None
    """The fan (3, N) of uneven beams; None for even ones."""


def beams_of(angles: FloatArray) -> Beams:
    """Order the beams at these angles (N,), radians; InputError for degrees, and for angles that do not form a fan."""
    return _beams(angles.tobytes())


@lru_cache(maxsize=16)
def _beams(raw: bytes) -> Beams:
    """Order the beams, from the bytes of the angles: most lidars have the same angles in every scan."""
    angles = np.frombuffer(raw, np.float64)
    _check_bearings(angles)
    order, bearings = _counter_clockwise(angles)
    first, step = float(bearings[0]), float(bearings[-1] - bearings[0]) / (len(bearings) - 1)
    return Beams(order, first, step, _fan(bearings, step))


def _check_bearings(angles: FloatArray) -> None:
    """Require finite radians within one turn."""
    for k in np.flatnonzero(~np.isfinite(angles)):
        raise InputError(f"angles[{k}] is {angles[k]}, not finite; each beam has a bearing, also one without an echo")
    k = np.abs(angles).argmax()
    if abs(angles[k]) > FULL_TURN:
        raise InputError(f"angles look like degrees: angles[{k}] is {angles[k]:g}; give numpy.radians(angles)")
    if np.ptp(angles) > FULL_TURN:
        raise InputError(
            f"angles go from {angles.min():g} to {angles.max():g}, more than one turn of 2 pi radians; "
            "give one turn of the lidar at a time"
        )
    if np.ptp(angles) == 0.0:
        raise InputError(f"angles are all {angles[0]:g}; give the bearing of each beam, radians")


def _counter_clockwise(angles: FloatArray) -> tuple[IntArray, FloatArray]:
    """Find the order in which the beams turn counter-clockwise, and their rising bearings in it.

    Beams that turn one way keep their order, or are reversed; others are sorted by bearing.
    """
    turned, places = np.unwrap(angles), np.arange(len(angles))
    steps = np.diff(turned)
    if (steps > 0.0).all():
        return places, turned
    if (steps < 0.0).all():
        return places[::-1], turned[::-1]
    wrapped = wrap_angles(angles)
    order = np.argsort(wrapped, kind="stable")
    return order, wrapped[order]


def _fan(angles: FloatArray, step: float) -> FloatArray | None:
    """Make the fan of uneven beams; None for even ones."""
    even = even_fan(float(angles[0]), step, len(angles))[0]
    if np.abs(angles - even).max() <= _EVEN:
        return None
    return np.vstack([angles, unit_vectors(angles).T])
