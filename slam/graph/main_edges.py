"""Soft edges between the walls of a building and its main directions, which walls have up to quarter turns."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.mapping.directions import THETA, VARIANCE, Directions, quarter_turn_difference
from slam.pose import FloatArray

MIN_LENGTH: Final = 1.0
"""Metres: shorter walls are held to no direction."""
WITHIN: Final = np.radians(2.0)
"""A wall lies in a main direction when it is nearer to it than this."""
KERNEL_SIGMAS: Final = 3.0
"""Standard deviations of a main direction, far above which a wall is not held to it."""
CORRELATION: Final = 2.0
"""Walls of one part of a building are off alike: what each tells is divided by this."""


class MainEdges(NamedTuple):
    """What is known of the directions of M walls beforehand."""

    direction: IntArray
    """(M,): number of a wall's main direction, -1 for none."""
    error: FloatArray
    """(M,) radians: the wall's own direction less its main one ..."""
    information: FloatArray
    """(M,): ... and how sure it is, rad^-2; 0 for a wall without."""


def no_main_edges(count: int) -> MainEdges:
    """No main direction for so many walls."""
    return MainEdges(np.full(count, -1, np.int64), np.zeros(count), np.zeros(count))


def find_main_edges(theta: FloatArray, lengths: FloatArray) -> MainEdges:
    """Soft edges of those walls that lie in a main direction of all of them.

    ``theta`` (M,) are the directions of their normals, radians, and ``lengths`` (M,) are in metres.
    """
    long = lengths >= MIN_LENGTH
    directions = Directions()
    directions.add(np.column_stack([theta, np.zeros(len(theta)), lengths])[long])
    direction, error = _nearest(theta, long, directions.main)
    information = np.zeros(len(theta))
    for k, variance in enumerate(directions.main[:, VARIANCE]):
        members = direction == k
        if members.any():
            off = error[members]
            information[members] = 1.0 / (CORRELATION * variance * (1.0 + off**2 / (KERNEL_SIGMAS**2 * variance)) ** 2)
            error[members] -= np.average(off, weights=information[members])
    return MainEdges(direction, error, information)


@compiled
def _nearest(theta: FloatArray, long: NDArray[np.bool_], main: FloatArray) -> tuple[IntArray, FloatArray]:
    """The main direction of each long wall and how far it is off, (M,) each."""
    direction, error = np.full(len(theta), -1, np.int64), np.zeros(len(theta))
    for m in range(len(theta)):
        nearest = WITHIN
        for k in range(len(main) if long[m] else 0):
            off = quarter_turn_difference(main[k, THETA], theta[m])
            if abs(off) < nearest:
                direction[m], error[m], nearest = k, off, abs(off)
    return direction, error
