"""Corners, compiled: two walls that end near where their lines cross end there."""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.mapping.wall_doubles import boxes_of
from slam.pose import FloatArray

REACH = 0.2  # metres, the largest cut of a wall to where it meets another: a cell
STUB = 0.5  # metres: an end of a wall behind a better wall, up to this length, was made of that wall's echoes
EXTENSION = 0.1  # metres, the largest extension
SAME_LINE = 0.34  # least sine between two walls that form a corner


@compiled
def meet_at_corners(ends: FloatArray) -> FloatArray:
    """Return the walls (M, 2, 2), the best supported first, each end moved to the nearest corner within range.

    A corner is where it meets another wall; a stub behind a better one, on its right, is cut off.
    """
    met, boxes = ends.copy(), boxes_of(ends, STUB)
    for m in range(len(ends)):
        for side in range(2):
            x, y = ends[m, side]
            nearest = STUB
            for k in range(len(ends)):
                if boxes[k, 0] < x and x < boxes[k, 1] and boxes[k, 2] < y and y < boxes[k, 3] and k != m:
                    nearest = _meet(ends[m], ends[k], k < m, side, nearest, met[m, side])
    return met


@compiled_on_views
def _meet(wall: FloatArray, other: FloatArray, is_better: bool, side: int, nearest: float, place: FloatArray) -> float:
    """Set the position to the intersection with the other wall, if it is nearer to its end; return the distance."""
    wx, wy = wall[1, 0] - wall[0, 0], wall[1, 1] - wall[0, 1]
    ox, oy = other[1, 0] - other[0, 0], other[1, 1] - other[0, 1]
    length, other_length = np.hypot(wx, wy), np.hypot(ox, oy)
    sine = (wx * oy - wy * ox) / (length * other_length)
    if abs(sine) < SAME_LINE:
        return nearest
    dx, dy = other[0, 0] - wall[0, 0], other[0, 1] - wall[0, 1]
    t = (dx * oy - dy * ox) / (wx * oy - wy * ox)
    u = (dx * wy - dy * wx) / (wx * oy - wy * ox)
    away = abs(t - side) * length
    beyond = max(-u, u - 1.0, 0.0) * other_length
    longer = (t - 1.0 if side == 1 else -t) * length
    behind = ox * (wall[side, 1] - other[0, 1]) < oy * (wall[side, 0] - other[0, 0])
    stub = behind and is_better and beyond == 0.0 and away < length - REACH
    if away >= nearest or (away >= REACH and not stub) or longer > EXTENSION or beyond > EXTENSION:
        return nearest
    if length <= 2 * REACH and (t < 0.25 if side == 1 else t > 0.75):  # it would vanish, or be reversed
        return nearest
    place[0], place[1] = wall[0, 0] + t * wx, wall[0, 1] + t * wy
    return float(away)
