"""Corners, compiled: two walls that end near where their lines cross end there."""

import numpy as np

from slam.compiled import compiled
from slam.mapping.wall_doubles import boxes_of
from slam.pose import FloatArray

REACH = 0.2  # metres that a wall is cut back to where it meets another, at most: a cell
EXTENSION = 0.1  # metres that it is made longer, at most
SAME_LINE = 0.34  # sine between two walls, below which they make no corner


@compiled
def meet_at_corners(ends: FloatArray) -> FloatArray:
    """The walls (M, 2, 2), each end carried to the nearest place within reach where it meets another wall."""
    met, boxes = ends.copy(), boxes_of(ends, REACH)
    for m in range(len(ends)):
        for side in range(2):
            x, y = ends[m, side]
            nearest = REACH
            for k in range(len(ends)):
                if boxes[k, 0] < x and x < boxes[k, 1] and boxes[k, 2] < y and y < boxes[k, 3] and k != m:
                    nearest = _meet(ends[m], ends[k], side, nearest, met[m, side])
    return met


@compiled
def _meet(wall: FloatArray, other: FloatArray, side: int, nearest: float, place: FloatArray) -> float:
    """Set the place to where the wall meets the other one, if it is nearer to its end; returns how near."""
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
    if away >= nearest or longer > EXTENSION or beyond > EXTENSION:
        return nearest
    if length <= 2 * REACH and (t < 0.25 if side == 1 else t > 0.75):  # it would be gone, or turned round
        return nearest
    place[0], place[1] = wall[0, 0] + t * wx, wall[0, 1] + t * wy
    return float(away)
