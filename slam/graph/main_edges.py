"""Soft edges between the walls of a building and its main directions (modulo a quarter turn).

Neighbouring walls have similar deviations: a wing may be oblique, and a street of blocks may bend. The common and the
individual deviations are estimated by a one-way analysis of variance over the parts of the building. If the parts
deviate and not the single walls, a hundred walls of one part have no more information than one.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.mapping.directions import MIN_SPREAD, THETA, VARIANCE, Directions, quarter_turn_difference
from slam.pose import FloatArray

MIN_LENGTH: Final = 1.0
"""Least length of a wall that is attached to a direction, metres."""
WITHIN: Final = np.radians(2.0)
"""Largest deviation of a wall from its main direction."""
KERNEL_SIGMAS: Final = 3.0
"""Standard deviations of a main direction beyond which a wall is not attached to it."""
PART: Final = 20.0
"""Side of a part of the building, metres, whose walls may have a common deviation."""


class MainEdges(NamedTuple):
    """Prior information on the directions of M walls."""

    direction: IntArray
    """(M,): index of a wall's main direction, -1 for none."""
    error: FloatArray
    """(M,): deviation of the wall's direction from the main one, radians."""
    information: FloatArray
    """(M,): information of that deviation, rad^-2; 0 for a wall without a main direction."""


def no_main_edges(count: int) -> MainEdges:
    """Return no main direction for ``count`` walls."""
    return MainEdges(np.full(count, -1, np.int64), np.zeros(count), np.zeros(count))


def find_main_edges(theta: FloatArray, lengths: FloatArray, places: FloatArray) -> MainEdges:
    """Attach the walls softly to the main directions of all of them.

    ``theta`` (M,) are the directions of their normals, radians, ``lengths`` (M,) and ``places`` (M, 2) are in metres.
    """
    long = lengths >= MIN_LENGTH
    directions = Directions()
    directions.add(np.column_stack([theta, np.zeros(len(theta)), lengths])[long])
    direction, error = _nearest(theta, long, directions.main)
    information = np.zeros(len(theta))
    for k, variance in enumerate(directions.main[:, VARIANCE]):
        members = direction == k
        off = error[members]
        known = _information(off, places[members], variance)
        if known.any():
            information[members] = known / (1.0 + off**2 / (KERNEL_SIGMAS**2 * variance)) ** 2
            error[members] -= np.average(off, weights=information[members])
    direction[information == 0.0] = -1
    return MainEdges(direction, np.where(direction < 0, 0.0, error), information)


def _information(off: FloatArray, places: FloatArray, variance: float) -> FloatArray:
    """Return the information of each wall (W,) about its main direction, rad^-2.

    The walls of a part share the information of the part; it is zero if the parts deviate more than the walls within
    one, and so have directions of their own.

    ``off`` (W,) are the deviations, with this ``variance``.
    """
    _, part, counts = np.unique(np.floor(places / PART), axis=0, return_inverse=True, return_counts=True)
    if len(counts) < 2:
        return 1.0 / (variance * (1.0 + np.full(len(off), len(off))))
    within, between = variance_components(off, part, counts)
    within = max(within, MIN_SPREAD**2)
    return np.where(between > within, 0.0, 1.0 / (within + counts[part] * between))


def variance_components(values: FloatArray, part: IntArray, counts: IntArray) -> tuple[float, float]:
    """Estimate the variances within and between the parts.

    ``part`` (W,) numbers the part of each value (W,), and ``counts`` (P,) the values of each; there are at least two
    parts. They come from the mean squares, as in Searle (1971), chapter 11.
    """
    means = np.bincount(part, values) / counts
    size, parts = len(values), len(counts)
    within = float(np.sum((values - means[part]) ** 2)) / max(size - parts, 1)
    among = float(np.sum(counts * (means - values.mean()) ** 2)) / (parts - 1)
    size_of_part = (size - float(np.sum(counts**2)) / size) / (parts - 1)
    return within, max((among - within) / size_of_part, 0.0)


@compiled
def _nearest(theta: FloatArray, long: NDArray[np.bool_], main: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the main direction of each long wall and its deviation, (M,) each."""
    direction, error = np.full(len(theta), -1, np.int64), np.zeros(len(theta))
    for m in range(len(theta)):
        nearest = WITHIN
        for k in range(len(main) if long[m] else 0):
            off = quarter_turn_difference(main[k, THETA], theta[m])
            if abs(off) < nearest:
                direction[m], error[m], nearest = k, off, abs(off)
    return direction, error
