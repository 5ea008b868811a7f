"""Walls that are there twice: of two side by side that face the same way, the one with less support goes, compiled."""

import numpy as np

from slam.compiled import compiled
from slam.pose import FloatArray

BESIDE = 0.30  # metres: what is nearer to a wall than this, and faces the same way, would be hidden or passed by beams
SAME_WAY = 0.94  # cosine between the two, at least


def without_doubles(ends: FloatArray, support: FloatArray, shortest: float) -> FloatArray:
    """What is left of the walls (M, 2, 2), the best supported first, where those that have more ``support`` (M,) take
    away what lies beside them; parts of less than ``shortest`` metres are left out."""
    return _without_doubles(ends[np.argsort(-support, kind="stable")], shortest)


@compiled
def _without_doubles(ends: FloatArray, shortest: float) -> FloatArray:
    kept, count = np.empty((4 * len(ends) + 4, 2, 2)), 0
    parts, boxes, box_of = np.empty((len(ends) + 1, 2)), boxes_of(ends, BESIDE), np.empty(len(kept), np.int64)
    for m in range(len(ends)):
        length = np.hypot(ends[m, 1, 0] - ends[m, 0, 0], ends[m, 1, 1] - ends[m, 0, 1])
        ux, uy = (ends[m, 1, 0] - ends[m, 0, 0]) / length, (ends[m, 1, 1] - ends[m, 0, 1]) / length
        parts[0, 0], parts[0, 1] = 0.0, length
        left = 1
        for k in range(count):
            if _overlap(boxes, m, box_of[k]):
                left = _take_away(parts, left, kept[k], ends[m, 0], ux, uy)
        for p in range(left):
            if parts[p, 1] - parts[p, 0] >= shortest and count < len(kept):
                for side in range(2):
                    kept[count, side, 0] = ends[m, 0, 0] + parts[p, side] * ux
                    kept[count, side, 1] = ends[m, 0, 1] + parts[p, side] * uy
                box_of[count] = m
                count += 1
    return kept[:count]


@compiled
def boxes_of(ends: FloatArray, margin: float) -> FloatArray:
    """Least and greatest x, least and greatest y (M, 4) of walls (M, 2, 2), with a margin in metres around them."""
    boxes = np.empty((len(ends), 4))
    for m in range(len(ends)):
        for axis in range(2):
            a, b = ends[m, 0, axis], ends[m, 1, axis]
            boxes[m, 2 * axis], boxes[m, 2 * axis + 1] = min(a, b) - margin, max(a, b) + margin
    return boxes


@compiled
def _overlap(boxes: FloatArray, m: int, k: int) -> bool:
    if boxes[m, 1] < boxes[k, 0] or boxes[k, 1] < boxes[m, 0]:
        return False
    return bool(boxes[m, 2] <= boxes[k, 3] and boxes[k, 2] <= boxes[m, 3])


@compiled
def _take_away(parts: FloatArray, left: int, wall: FloatArray, start: FloatArray, ux: float, uy: float) -> int:
    """Take from the parts (P, 2) of the line from ``start`` along (ux, uy) what lies beside a better wall (2, 2)."""
    wx, wy = wall[1, 0] - wall[0, 0], wall[1, 1] - wall[0, 1]
    if wx * ux + wy * uy < SAME_WAY * np.hypot(wx, wy):
        return left
    begin = (wall[0, 0] - start[0]) * ux + (wall[0, 1] - start[1]) * uy
    end = (wall[1, 0] - start[0]) * ux + (wall[1, 1] - start[1]) * uy
    low, high = max(begin, parts[0, 0]), min(end, parts[left - 1, 1]) if left > 0 else -1.0
    if low >= high:
        return left
    middle = 0.5 * (low + high)
    px, py = start[0] + middle * ux - wall[0, 0], start[1] + middle * uy - wall[0, 1]
    if abs(px * wy - py * wx) > BESIDE * np.hypot(wx, wy):
        return left
    p = 0
    while p < left:
        a, b = parts[p]
        if b <= begin or a >= end:
            p += 1
        elif a < begin and b > end:
            for q in range(left, p + 1, -1):
                parts[q, 0], parts[q, 1] = parts[q - 1, 0], parts[q - 1, 1]
            parts[p, 1], parts[p + 1, 0], parts[p + 1, 1] = begin, end, b
            left, p = left + 1, p + 2
        elif a < begin:
            parts[p, 1] = begin
            p += 1
        elif b > end:
            parts[p, 0] = end
            p += 1
        else:
            for q in range(p, left - 1):
                parts[q, 0], parts[q, 1] = parts[q + 1, 0], parts[q + 1, 1]
            left -= 1
    return left
