"""The grid of surfels, compiled: what was seen goes in, what was seen through goes out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.pose import FloatArray

X, Y, NX, NY, INFORMATION, HITS, MISSES = range(7)
"""Columns of surfels (S, 7): centre (m, map frame), unit normal away from where it was seen (0, 0 for a cluster of
points), information along the normal (m^-2), how often it was hit, and missed since."""
SAME_WAY = 0.8  # cosine between the normals of a surfel and of what may join it
BETWEEN = 0.25  # information of a piece of wall between two beams, over that of a piece with beams
EDGE_ON = 0.35  # cosine of incidence below which it is not asked whether a beam went through a surfel
FADE = 2.0  # misses that a surfel may have more than its hits allow
DOUBT = 0.1  # of a miss for what is not yet sure, when something else was seen in its cell


class Grid(NamedTuple):
    """Surfels in linked lists, one for each cell."""

    head: NDArray[np.int32]
    """(rows, columns): the first surfel of each cell, -1 for none."""
    next: NDArray[np.int32]
    """(S,): the next surfel of the same cell, or of the free list, -1 for none."""
    surfels: FloatArray
    corner: IntArray
    """(2,): row and column of the map frame in which ``head[0, 0]`` lies."""
    cell: float
    """Metres."""
    used: IntArray
    """(3,): how many places of ``surfels`` were ever taken, the first of the free list or -1, and how many live."""


@compiled
def room(facets: FloatArray, pose: FloatArray, cell: float) -> tuple[IntArray, IntArray, int]:
    """The least and the greatest row and column (2,) that facets (F, 7) seen from ``pose`` (3,) touch, and how many
    surfels they and the walls between them make at most."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    way = last_x = last_y = 0.0
    for f in range(len(facets)):
        x, y = pose[0] + c * facets[f, 0] - s * facets[f, 1], pose[1] + s * facets[f, 0] + c * facets[f, 1]
        low[0], low[1] = min(low[0], y), min(low[1], x)
        high[0], high[1] = max(high[0], y), max(high[1], x)
        if f > 0:
            way += abs(x - last_x) + abs(y - last_y)
        last_x, last_y = x, y
    most = int(way * 2.0 / cell) + 2 * len(facets)
    return np.floor(low / cell).astype(np.int64), np.floor(high / cell).astype(np.int64), most


@compiled
def free_ranges(ranges: FloatArray, range_min: float, range_max: float, no_echo_reach: float) -> FloatArray:
    """How far each beam was certainly free, metres, shape (N,): 0 for an error or a reading that is too near."""
    free = np.zeros(len(ranges))
    for j in range(len(ranges)):
        if range_min <= ranges[j] <= range_max:
            free[j] = ranges[j]
        if ranges[j] == np.inf:
            free[j] = min(no_echo_reach, range_max)
    return free


@compiled
def put(grid: Grid, facets: FloatArray, pose: FloatArray, gate: float, max_hits: float, pose_sigma: float) -> None:
    """Add facets (F, 7), sensor frame, as seen from ``pose`` (3,); the grid must cover them.

    A wall goes on between the facets of one segment, however far apart the beams were.
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    last_x = last_y = 0.0
    for f in range(len(facets)):
        fx, fy, fnx, fny, variance = facets[f, 0], facets[f, 1], facets[f, 2], facets[f, 3], facets[f, 4]
        x, y = pose[0] + c * fx - s * fy, pose[1] + s * fx + c * fy
        nx, ny = c * fnx - s * fny, s * fnx + c * fny
        information = 1.0 / (variance + pose_sigma * pose_sigma)
        steps = int(np.hypot(x - last_x, y - last_y) / grid.cell + 0.5) if facets[f, 6] > 0.0 else 0
        for i in range(1, steps):
            t = i / steps
            _put_one(
                grid,
                last_x + t * (x - last_x),
                last_y + t * (y - last_y),
                nx,
                ny,
                BETWEEN * information,
                gate,
                max_hits,
            )
        _put_one(grid, x, y, nx, ny, information, gate, max_hits)
        last_x, last_y = x, y


@compiled
def _put_one(
    grid: Grid, x: float, y: float, nx: float, ny: float, information: float, gate: float, max_hits: float
) -> None:
    """Merge into the nearest surfel of the cell that faces this way, or begin one."""
    row, column = int(np.floor(y / grid.cell)) - grid.corner[0], int(np.floor(x / grid.cell)) - grid.corner[1]
    wall = nx != 0.0 or ny != 0.0
    best, nearest = -1, gate
    k = grid.head[row, column]
    while k >= 0:
        s = grid.surfels[k]
        if wall == (s[NX] != 0.0 or s[NY] != 0.0):
            dx, dy = x - s[X], y - s[Y]
            distance = abs(dx * s[NX] + dy * s[NY]) if wall else np.hypot(dx, dy)
            if distance < nearest and (not wall or nx * s[NX] + ny * s[NY] > SAME_WAY):
                best, nearest = k, distance
        k = grid.next[k]
    if best >= 0:
        _doubt(grid, grid.head[row, column], best, nx, ny, max_hits)
        _merge(grid.surfels[best], x, y, nx, ny, information, max_hits)
        return
    if grid.used[1] >= 0:
        best = grid.used[1]
        grid.used[1] = grid.next[best]
    else:
        best = grid.used[0]
        grid.used[0] += 1
    grid.used[2] += 1
    s = grid.surfels[best]
    s[X], s[Y], s[NX], s[NY], s[INFORMATION], s[HITS], s[MISSES] = x, y, nx, ny, information, 1.0, 0.0
    grid.next[best] = grid.head[row, column]
    grid.head[row, column] = best


@compiled
def _doubt(grid: Grid, first: int, seen: int, nx: float, ny: float, max_hits: float) -> None:
    """Of the surfels of a cell, those not yet sure that should have been seen with ``seen`` fade: what is hit less than
    one time in ten that its neighbour is hit is noise. It would pile up along every wall for as long as one drives."""
    k = first
    while k >= 0:
        s = grid.surfels[k]
        if k != seen and s[HITS] < max_hits and nx * s[NX] + ny * s[NY] >= 0.0:
            s[MISSES] += DOUBT
        k = grid.next[k]


@compiled
def _merge(s: FloatArray, x: float, y: float, nx: float, ny: float, information: float, max_hits: float) -> None:
    """Weighted means; nothing moves any more once it was seen often."""
    s[MISSES] = max(0.0, s[MISSES] - 1.0)
    if s[HITS] >= max_hits:
        return
    share = information / (s[INFORMATION] + information)
    s[X] += share * (x - s[X])
    s[Y] += share * (y - s[Y])
    if nx != 0.0 or ny != 0.0:
        mx, my = s[NX] + share * (nx - s[NX]), s[NY] + share * (ny - s[NY])
        norm = np.sqrt(mx * mx + my * my)
        s[NX], s[NY] = mx / norm, my / norm
    s[INFORMATION] += information
    s[HITS] += 1.0


@compiled
def carve(
    grid: Grid, ranges: FloatArray, angle_min: float, increment: float, pose: FloatArray, reach: float, margin: float,
    miss_ratio: float,
) -> None:  # fmt: skip
    """Count a miss for every surfel within ``reach`` that the beams passed by more than ``margin`` metres, and remove
    those missed too often. ``ranges`` (N,) is how far each beam was free, 0 where that is not known."""
    corner, cell = grid.corner, grid.cell
    rows, columns = grid.head.shape
    first_row = max(int(np.floor((pose[1] - reach) / cell)) - corner[0], 0)
    first_column = max(int(np.floor((pose[0] - reach) / cell)) - corner[1], 0)
    for row in range(first_row, min(int(np.floor((pose[1] + reach) / cell)) - corner[0] + 1, rows)):
        for column in range(first_column, min(int(np.floor((pose[0] + reach) / cell)) - corner[1] + 1, columns)):
            before, k = -1, grid.head[row, column]
            while k >= 0:
                after = grid.next[k]
                s = grid.surfels[k]
                if _seen_through(s, ranges, angle_min, increment, pose, reach, margin):
                    s[MISSES] += 1.0
                if s[MISSES] > FADE + miss_ratio * s[HITS]:
                    s[HITS] = 0.0
                    if before < 0:
                        grid.head[row, column] = after
                    else:
                        grid.next[before] = after
                    grid.next[k] = grid.used[1]
                    grid.used[1] = k
                    grid.used[2] -= 1
                else:
                    before = k
                k = after


@compiled
def count_seen_through(
    grid: Grid, ranges: FloatArray, angle_min: float, increment: float, pose: FloatArray, reach: float, margin: float
) -> int:
    """How many surfels that were seen twice or more the beams passed, as in ``carve``, which would count a miss."""
    count, cell = 0, grid.cell
    rows, columns = grid.head.shape
    first_row = max(int(np.floor((pose[1] - reach) / cell)) - grid.corner[0], 0)
    first_column = max(int(np.floor((pose[0] - reach) / cell)) - grid.corner[1], 0)
    for row in range(first_row, min(int(np.floor((pose[1] + reach) / cell)) - grid.corner[0] + 1, rows)):
        for column in range(first_column, min(int(np.floor((pose[0] + reach) / cell)) - grid.corner[1] + 1, columns)):
            k = grid.head[row, column]
            while k >= 0:
                s = grid.surfels[k]
                if s[HITS] >= 2.0 and _seen_through(s, ranges, angle_min, increment, pose, reach, margin):
                    count += 1
                k = grid.next[k]
    return count


@compiled
def _seen_through(
    s: FloatArray, ranges: FloatArray, angle_min: float, increment: float, pose: FloatArray, reach: float, margin: float
) -> bool:
    """Whether the beam towards the surfel and both its neighbours went farther."""
    dx, dy = s[X] - pose[0], s[Y] - pose[1]
    distance = np.sqrt(dx * dx + dy * dy)
    if not 0.1 < distance < reach:
        return False
    wall = s[NX] != 0.0 or s[NY] != 0.0
    if wall and abs(dx * s[NX] + dy * s[NY]) < EDGE_ON * distance:
        return False
    bearing = np.arctan2(dy, dx) - pose[2] - angle_min
    bearing -= 2.0 * np.pi * np.floor(bearing / (2.0 * np.pi))
    j = int(bearing / increment + 0.5)
    if not 1 <= j < len(ranges) - 1:
        return False
    return bool(min(ranges[j - 1], ranges[j], ranges[j + 1]) > distance + margin)
