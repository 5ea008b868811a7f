"""Removes duplicate walls: of two that show the same wall, the one with less support. Compiled."""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.pose import FloatArray

BESIDE = 0.30  # metres: two walls this near that face the same side show the same wall, as one would hide the other
SAME_WAY = 0.94  # least cosine between the normals of two such walls
NEAR = 0.12  # metres: a rarely seen line this near to a wall, at another angle, comes from echoes of that wall
SAME_SIDE = 0.3  # least cosine between the normals of the two: otherwise they may form a corner
HARDLY_SEEN = 0.5  # a line is rarely seen if its mean count is below this share of that of the wall


def without_doubles(ends: FloatArray, support: FloatArray, shortest: float) -> FloatArray:
    """Remove duplicates from the walls (M, 2, 2), and sort them, the best supported first.

    Walls with more ``support`` (M,), their mean count times their length, replace others that show the same; parts of
    less than ``shortest`` metres are left out.
    """
    best_first = np.argsort(-support, kind="stable")
    return _without_doubles(ends[best_first], support[best_first], shortest)


@compiled
def boxes_of(ends: FloatArray, margin: float) -> FloatArray:
    """Return the least and greatest x, the least and greatest y (M, 4) of walls (M, 2, 2), plus a margin in metres."""
    boxes = np.empty((len(ends), 4))
    for m in range(len(ends)):
        for axis in range(2):
            a, b = ends[m, 0, axis], ends[m, 1, axis]
            boxes[m, 2 * axis], boxes[m, 2 * axis + 1] = min(a, b) - margin, max(a, b) + margin
    return boxes


@compiled
def _without_doubles(ends: FloatArray, support: FloatArray, shortest: float) -> FloatArray:
    kept, count = np.empty((4 * len(ends) + 4, 2, 2)), 0
    box_of, parts = np.empty(len(kept), np.int64), np.empty((len(kept), 2))
    boxes, means = boxes_of(ends, BESIDE), np.empty(len(ends))
    for m in range(len(ends)):
        length = np.hypot(ends[m, 1, 0] - ends[m, 0, 0], ends[m, 1, 1] - ends[m, 0, 1])
        means[m] = support[m] / length
        parts[0, 0], parts[0, 1] = 0.0, length
        left = 1
        for k in range(count):
            if _overlap(boxes, m, box_of[k]):
                begin, end = _shown_twice(ends[m], kept[k], means[m] < HARDLY_SEEN * means[box_of[k]])
                left = _take_away(parts, left, begin, end)
        for p in range(left):
            if parts[p, 1] - parts[p, 0] >= shortest and count < len(kept):
                for side in range(2):
                    for axis in range(2):
                        direction = (ends[m, 1, axis] - ends[m, 0, axis]) / length
                        kept[count, side, axis] = ends[m, 0, axis] + parts[p, side] * direction
                box_of[count] = m
                count += 1
    return kept[:count]


@compiled_on_views
def _overlap(boxes: FloatArray, m: int, k: int) -> bool:
    if boxes[m, 1] < boxes[k, 0] or boxes[k, 1] < boxes[m, 0]:
        return False
    return bool(boxes[m, 2] <= boxes[k, 3] and boxes[k, 2] <= boxes[m, 3])


@compiled_on_views
def _shown_twice(wall: FloatArray, better: FloatArray, hardly_seen: bool) -> tuple[float, float]:
    """Return begin and end, metres along a wall (2, 2), of the part that a better one shows; begin >= end for none."""
    ux, uy = wall[1, 0] - wall[0, 0], wall[1, 1] - wall[0, 1]
    bx, by = better[1, 0] - better[0, 0], better[1, 1] - better[0, 1]
    length, reach = np.hypot(ux, uy), np.hypot(bx, by)
    cosine, sine = (ux * bx + uy * by) / (length * reach), (bx * uy - by * ux) / (length * reach)
    if cosine < SAME_SIDE or (cosine < SAME_WAY and not hardly_seen):
        return 0.0, 0.0
    most = BESIDE if cosine >= SAME_WAY else NEAR
    px, py = wall[0, 0] - better[0, 0], wall[0, 1] - better[0, 1]
    along, across = (px * bx + py * by) / reach, (bx * py - by * px) / reach
    begin, end = -along / cosine, (reach - along) / cosine
    if abs(sine) * length > 1e-9:
        a, b = (-most - across) / sine, (most - across) / sine
        return max(begin, min(a, b)), min(end, max(a, b))
    return (begin, end) if abs(across) <= most else (0.0, 0.0)


@compiled_on_views
def _take_away(parts: FloatArray, left: int, begin: float, end: float) -> int:
    """Remove the part from ``begin`` to ``end`` from the first ``left`` parts (P, 2); return the number left."""
    p = 0
    while p < left and begin < end:
        a, b = parts[p, 0], parts[p, 1]
        if b <= begin or a >= end:
            p += 1
        elif a < begin and b > end:
            parts[p, 1] = begin
            parts[left, 0], parts[left, 1] = end, b
            left += 1
        elif a < begin:
            parts[p, 1] = begin
        elif b > end:
            parts[p, 0] = end
        else:
            left -= 1
            parts[p, 0], parts[p, 1] = parts[left, 0], parts[left, 1]
    return left
