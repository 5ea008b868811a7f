"""Evidence for poses of submaps: overlapping walls, against walls on floor that was seen to be free.

Compiled. A pose is refined by least squares on the overlapping walls. Its score measures how well these walls fix the
pose in every direction. It is reduced by the length of walls of one submap that lie on floor which the other submap saw
to be free.
"""

from typing import Final

import numpy as np

from slam.compiled import compiled, compiled_on_views, wrapped
from slam.graph.constellation import (
    ALONG_X,
    ALONG_Y,
    CELL,
    CELLS,
    LENGTH,
    MIDDLE_X,
    MIDDLE_Y,
    Constellation,
    Floor,
    cell_of,
)
from slam.graph.wall_votes import fixedness, moved
from slam.lines.segments import IntArray
from slam.matching.coarse_search import HEADING, PLACE_X, PLACE_Y, SCORE
from slam.pose import FloatArray

KERNELS = (0.25, 0.15, 0.1)
"""Standard deviation of the offset of two matching walls, metres: two rounds refine, the last one scores."""
SAME_WAY: Final = 0.97
"""Least cosine between two matching walls: 14 degrees."""
MIN_OVERLAP: Final = 0.1
"""Least overlap of two matching walls, metres."""
MAX_SIGMAS: Final = 3.0
"""Standard deviations of the offset beyond which two walls do not match."""
PRIOR: Final = np.array([0.1, 0.1, 1.0])
"""Information of a weak prior that keeps x, y (metres of wall) and heading (metres^3) where walls do not fix them."""
SLACK: Final = 1.0
"""Metres by which the rounds may move two walls against each other."""
CONTRADICTION: Final = 8.0
"""Metres of contradicted wall that halve a score: doors move, and the robot sees too far through a missed wall."""


@compiled
def weigh_places(places: FloatArray, submap: Constellation, other: Constellation) -> None:
    """Refine every pose (N, 4) of a submap in another one, and score it."""
    for k in range(len(places)):
        x, y, theta = places[k, PLACE_X], places[k, PLACE_Y], places[k, HEADING]
        pairs = _pairs(moved(submap.walls, x, y, theta), other.walls)
        for kernel in KERNELS[:-1]:
            there = moved(submap.walls, x, y, theta)
            information, gradient = normal_equations(there, other.walls, pairs, x, y, kernel)
            step = np.linalg.solve(information + np.diag(PRIOR), gradient)
            x, y, theta = x + step[0], y + step[1], theta + step[2]
        information, _ = normal_equations(moved(submap.walls, x, y, theta), other.walls, pairs, x, y, KERNELS[-1])
        places[k, PLACE_X], places[k, PLACE_Y], places[k, HEADING] = x, y, wrapped(theta)
        against = CONTRADICTION + contradicted(places[k], submap, other)
        places[k, SCORE] = fixedness(information[0, 0], information[0, 1], information[1, 1]) / against


@compiled
def contradicted(place: FloatArray, submap: Constellation, other: Constellation) -> float:
    """Return the metres of wall of either submap that lie on the free floor of the other at a pose (4,)."""
    x, y, theta = place[PLACE_X], place[PLACE_Y], place[HEADING]
    c, s = np.cos(theta), np.sin(theta)
    there = moved(submap.walls, x, y, theta)
    back = moved(other.walls, -c * x - s * y, s * x - c * y, -theta)
    return metres_on(there, other.free) + metres_on(back, submap.free)


@compiled
def _pairs(walls: FloatArray, others: FloatArray) -> IntArray:
    """Return the pairs (P, 2) of walls that face the same way and overlap, or would within SLACK."""
    pairs, count = np.empty((len(walls) * len(others), 2), np.int64), 0
    for a in range(len(walls)):
        for b in range(len(others)):
            ux, uy = others[b, ALONG_X], others[b, ALONG_Y]
            if walls[a, ALONG_X] * ux + walls[a, ALONG_Y] * uy < SAME_WAY:
                continue
            dx, dy = walls[a, MIDDLE_X] - others[b, MIDDLE_X], walls[a, MIDDLE_Y] - others[b, MIDDLE_Y]
            slope = abs(walls[a, ALONG_X] * uy - walls[a, ALONG_Y] * ux)
            half = 0.5 * (walls[a, LENGTH] + others[b, LENGTH])
            if abs(dx * ux + dy * uy) < half + SLACK and abs(dy * ux - dx * uy) < slope * half + SLACK:
                pairs[count, 0], pairs[count, 1] = a, b
                count += 1
    return pairs[:count]


@compiled
def normal_equations(
    walls: FloatArray, others: FloatArray, pairs: IntArray, x: float, y: float, kernel: float
) -> tuple[FloatArray, FloatArray]:
    """Return the information (3, 3) and the negative gradient (3,) for a step of x, y and theta about (x, y).

    They are summed over overlapping pairs of walls, weighted by their overlap and their distance.
    """
    information, gradient = np.zeros((3, 3)), np.zeros(3)
    for p in range(len(pairs)):
        _add_pair(walls[pairs[p, 0]], others[pairs[p, 1]], x, y, kernel, information, gradient)
    information[1, 0], information[2, 0], information[2, 1] = information[0, 1], information[0, 2], information[1, 2]
    return information, gradient


@compiled_on_views
def _add_pair(
    wall: FloatArray, other: FloatArray, x: float, y: float, kernel: float, information: FloatArray,
    gradient: FloatArray,
) -> None:  # fmt: skip
    """Add two walls that face the same way, if they overlap."""
    ux, uy = other[ALONG_X], other[ALONG_Y]
    cosine, sine = wall[ALONG_X] * ux + wall[ALONG_Y] * uy, wall[ALONG_X] * uy - wall[ALONG_Y] * ux
    dx, dy = wall[MIDDLE_X] - other[MIDDLE_X], wall[MIDDLE_Y] - other[MIDDLE_Y]
    along, half = dx * ux + dy * uy, 0.5 * cosine * wall[LENGTH]
    begin, end = max(along - half, -0.5 * other[LENGTH]), min(along + half, 0.5 * other[LENGTH])
    at = 0.5 * (begin + end)  # middle of the overlap, along the other
    offset = dy * ux - dx * uy - (at - along) * sine / cosine
    if end - begin < MIN_OVERLAP or abs(offset) > MAX_SIGMAS * kernel:
        return
    weight = (end - begin) * np.exp(-0.5 * (offset / kernel) ** 2)
    px, py = other[MIDDLE_X] + at * ux - x, other[MIDDLE_Y] + at * uy - y
    lever = px * ux + py * uy  # derivative of the offset by the turn, metres
    turning = weight * (end - begin) ** 2 / 12.0  # information of a piece this long about the direction
    information[0, 0] += weight * uy * uy
    information[0, 1] -= weight * uy * ux
    information[0, 2] -= weight * uy * lever
    information[1, 1] += weight * ux * ux
    information[1, 2] += weight * ux * lever
    information[2, 2] += weight * lever * lever + turning
    gradient[0] += weight * uy * offset
    gradient[1] -= weight * ux * offset
    gradient[2] -= weight * lever * offset - turning * sine


@compiled_on_views
def metres_on(walls: FloatArray, free: Floor) -> float:
    """Return the metres of the walls on free floor."""
    metres = 0.0
    for m in range(len(walls)):
        pieces = int(np.ceil(walls[m, LENGTH] / CELL))
        for k in range(pieces):
            along = ((k + 0.5) / pieces - 0.5) * walls[m, LENGTH]
            x = walls[m, MIDDLE_X] + along * walls[m, ALONG_X]
            y = walls[m, MIDDLE_Y] + along * walls[m, ALONG_Y]
            row, column = cell_of(x, y, CELLS)
            if row >= 0 and free[row, column]:
                metres += walls[m, LENGTH] / pieces
    return metres
