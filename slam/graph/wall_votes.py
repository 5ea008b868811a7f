"""Votes of pairs of walls for the place of one submap in another, compiled.

Each pair of walls votes for the rotation that makes them face the same way. At a rotation, each such pair votes for the
strip of shifts that put one wall on the other. The pair fixes the position across the wall and leaves it free along it:
so a vote is an information matrix, and the score of a shift measures how well its votes fix it in every direction. A
corridor alone scores low.
"""

from typing import Final

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.graph.constellation import ALONG_X, ALONG_Y, CELL, LENGTH, MIDDLE_X, MIDDLE_Y, cell_of
from slam.lines.segments import IntArray
from slam.matching.coarse_search import HEADING, PLACE_X, PLACE_Y, SCORE
from slam.pose import FloatArray

TURN_BINS: Final = 180
"""Bins of a full turn: 2 degrees."""
TURNS: Final = 8
"""Largest number of rotations that are examined."""
TURNS_APART: Final = 5
"""Least number of bins between two of them."""
REACH: Final = 40
"""Largest shift to each side, cells; 10 m: submaps of 8 m of path farther apart share little."""
SHIFTS: Final = 12
"""Number of shifts that are returned at each rotation."""
SHIFTS_APART: Final = 2
"""Number of cells around a shift in which no other one is returned."""
LONGEST_VOTE: Final = 3.0
"""Largest length of a wall that counts, metres: longer walls fix rotation and position no better."""
SAME_WAY: Final = 0.9925
"""Cosine between two walls that face the same way: 7 degrees."""
CHANCE: Final = 1.0
"""Information in each direction, metres of wall, that walls give by chance; it is subtracted from the score."""
MIN_OVERLAP: Final = 0.1
"""Least overlap of two walls for a vote, metres."""
BLUR = (0.5, 1.0, 0.5)
"""Weights of a vote one cell before, on and one cell behind the wall."""
XX, XY, YY = range(3)
"""Planes of votes (2 REACH, 2 REACH, 3): the information, metres of wall."""


@compiled
def moved(walls: FloatArray, x: float, y: float, theta: float) -> FloatArray:
    """Transform the walls (M, 5) by this pose."""
    c, s = np.cos(theta), np.sin(theta)
    there = walls.copy()
    for m in range(len(walls)):
        there[m, MIDDLE_X] = x + c * walls[m, MIDDLE_X] - s * walls[m, MIDDLE_Y]
        there[m, MIDDLE_Y] = y + s * walls[m, MIDDLE_X] + c * walls[m, MIDDLE_Y]
        there[m, ALONG_X] = c * walls[m, ALONG_X] - s * walls[m, ALONG_Y]
        there[m, ALONG_Y] = s * walls[m, ALONG_X] + c * walls[m, ALONG_Y]
    return there


@compiled
def places_voted_for(walls: FloatArray, others: FloatArray) -> FloatArray:
    """Return poses (N, 4) of the walls among the others, SHIFTS at each of TURNS rotations, with their scores."""
    turns = _best_turns(turn_votes(walls, others))
    places, count = np.empty((TURNS * SHIFTS, 4)), 0
    for k in range(len(turns)):
        theta = turns[k] * 2.0 * np.pi / TURN_BINS
        scores = _scores(shift_votes(moved(walls, 0.0, 0.0, theta), others))
        best_columns = np.zeros(2 * REACH, np.int64)
        _find_best(scores, best_columns, 0, 2 * REACH)
        for _ in range(SHIFTS):
            row = _best_row(scores, best_columns)
            column = best_columns[row]
            if scores[row, column] <= 0.0:
                break
            places[count, SCORE], places[count, HEADING] = scores[row, column], theta
            places[count, PLACE_X] = (column + 0.5 - REACH) * CELL
            places[count, PLACE_Y] = (row + 0.5 - REACH) * CELL
            count += 1
            low_row, low_column = max(row - SHIFTS_APART, 0), max(column - SHIFTS_APART, 0)
            scores[low_row : row + SHIFTS_APART + 1, low_column : column + SHIFTS_APART + 1] = 0.0
            _find_best(scores, best_columns, low_row, min(row + SHIFTS_APART + 1, 2 * REACH))
    return places[:count]


@compiled_on_views
def _find_best(scores: FloatArray, best_columns: IntArray, low: int, high: int) -> None:
    """Fill in the column of the best score of each row from ``low`` up to ``high``; the first of equals."""
    for row in range(low, high):
        best = 0
        for column in range(1, scores.shape[1]):
            if scores[row, column] > scores[row, best]:
                best = column
        best_columns[row] = best


@compiled_on_views
def _best_row(scores: FloatArray, best_columns: IntArray) -> int:
    """Return the row of the best score of all; the first of equals."""
    best = 0
    for row in range(1, len(scores)):
        if scores[row, best_columns[row]] > scores[best, best_columns[best]]:
            best = row
    return best


@compiled
def turn_votes(walls: FloatArray, others: FloatArray) -> FloatArray:
    """Return the votes of all pairs of walls for their rotation, (TURN_BINS,), blurred by two bins to each side."""
    votes = np.zeros(TURN_BINS)
    for a in range(len(walls)):
        for b in range(len(others)):
            cosine, sine = _turn(walls[a], others[b])
            at = np.arctan2(sine, cosine) * TURN_BINS / (2.0 * np.pi)
            low = int(np.floor(at))
            weight = min(walls[a, LENGTH], LONGEST_VOTE) * min(others[b, LENGTH], LONGEST_VOTE)
            votes[low % TURN_BINS] += weight * (low + 1 - at)
            votes[(low + 1) % TURN_BINS] += weight * (at - low)
    blurred = np.zeros(TURN_BINS)
    for k in range(TURN_BINS):
        near = votes[k - 1] + votes[(k + 1) % TURN_BINS]
        blurred[k] = votes[k] + 0.5 * near + 0.25 * (votes[k - 2] + votes[(k + 2) % TURN_BINS])
    return blurred


@compiled
def _best_turns(votes: FloatArray) -> IntArray:
    """Return the bins with the most votes, TURNS at most."""
    left, turns, count = votes.copy(), np.empty(TURNS, np.int64), 0
    while count < TURNS:
        best = int(np.argmax(left))
        if left[best] <= 0.0:
            break
        turns[count] = best
        count += 1
        for k in range(best - TURNS_APART + 1, best + TURNS_APART):
            left[k % TURN_BINS] = 0.0
    return turns[:count]


@compiled
def shift_votes(walls: FloatArray, others: FloatArray) -> FloatArray:
    """Return the votes (2 REACH, 2 REACH, 3) of all pairs of walls that face the same way for their shift."""
    votes = np.zeros((2 * REACH, 2 * REACH, 3))
    for a in range(len(walls)):
        for b in range(len(others)):
            cosine, _ = _turn(walls[a], others[b])
            if cosine > SAME_WAY:
                _vote(walls[a], others[b], votes)
    return votes


@compiled_on_views
def _vote(wall: FloatArray, other: FloatArray, votes: FloatArray) -> None:
    """Add the strip of one pair: at each of its shifts the metres of overlap."""
    ux, uy = other[ALONG_X], other[ALONG_Y]
    dx, dy = other[MIDDLE_X] - wall[MIDDLE_X], other[MIDDLE_Y] - wall[MIDDLE_Y]
    half, most = 0.5 * (wall[LENGTH] + other[LENGTH]), min(wall[LENGTH], other[LENGTH], LONGEST_VOTE)
    steps = int((half - MIN_OVERLAP) / CELL)
    for step in range(-steps, steps + 1):
        metres = min(half - abs(step) * CELL, most)
        for side in range(-1, 2):
            row, column = cell_of(dx + CELL * (step * ux - side * uy), dy + CELL * (step * uy + side * ux), REACH)
            if row >= 0:
                weight = metres * BLUR[side + 1]
                votes[row, column, XX] += weight * uy * uy
                votes[row, column, XY] -= weight * uy * ux
                votes[row, column, YY] += weight * ux * ux


@compiled
def _scores(votes: FloatArray) -> FloatArray:
    """Return the score (R, C) of each shift from its votes (R, C, 3)."""
    rows, columns, _ = votes.shape
    scores = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            scores[i, j] = fixedness(votes[i, j, XX], votes[i, j, XY], votes[i, j, YY])
    return scores


@compiled_on_views
def fixedness(xx: float, xy: float, yy: float) -> float:
    """Return how well walls fix a position in every direction, metres of wall.

    It is the root of the determinant of their information, and small if they are all parallel.
    """
    return float(np.sqrt((xx + CHANCE) * (yy + CHANCE) - xy * xy) - CHANCE)


@compiled_on_views
def _turn(wall: FloatArray, other: FloatArray) -> tuple[float, float]:
    """Return cosine and sine of the rotation from one wall to the other."""
    ax, ay, bx, by = wall[ALONG_X], wall[ALONG_Y], other[ALONG_X], other[ALONG_Y]
    return ax * bx + ay * by, ax * by - ay * bx
