"""Counts beams that went through surfels, and removes surfels with too many, compiled."""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.mapping.free_beams import FreeBeams, beam_towards, is_hidden
from slam.mapping.surfel_grid import ALIVE, FREE, HITS, MISSES, NX, NY, Grid, X, Y
from slam.pose import FloatArray

EDGE_ON_COSINE = 0.35  # cosine of incidence below which a passing beam does not count as a miss
FORGIVEN_MISSES = 2.0  # misses that a surfel may have beyond those allowed by its hits
MIN_DISTANCE = 0.1  # metres: nearer surfels are not checked


@compiled
def carve(grid: Grid, beams: FreeBeams, pose: FloatArray, reach: float, margin: float, miss_ratio: float) -> None:
    """Count a miss for every surfel within ``reach`` that the beams from ``pose`` (3,) passed by more than ``margin``.

    The margin is in metres. Surfels with too many misses are removed.
    """
    surfels, farthest = grid.surfels, beams.farthest
    x, y, c, s = pose[0], pose[1], np.cos(pose[2]), np.sin(pose[2])
    low_row, high_row, low_column, high_column = cells_around(grid, pose, reach)
    for row in range(low_row, high_row):
        for column in range(low_column, high_column):
            before, k = -1, grid.head[row, column]
            while k >= 0:
                after = grid.next[k]
                dx, dy = surfels[k, X] - x, surfels[k, Y] - y
                beyond = np.sqrt(dx * dx + dy * dy) + margin
                hidden = is_hidden(farthest, c * dx + s * dy, c * dy - s * dx, beyond)
                if not hidden and _seen_through(surfels, k, beams, pose, reach, margin):
                    surfels[k, MISSES] += 1.0
                if surfels[k, MISSES] > FORGIVEN_MISSES + miss_ratio * surfels[k, HITS]:
                    surfels[k, HITS] = 0.0
                    if before < 0:
                        grid.head[row, column] = after
                    else:
                        grid.next[before] = after
                    grid.next[k] = grid.counts[FREE]
                    grid.counts[FREE] = k
                    grid.counts[ALIVE] -= 1
                else:
                    before = k
                k = after


@compiled_on_views
def count_seen_through(grid: Grid, beams: FreeBeams, pose: FloatArray, reach: float, margin: float) -> int:
    """Return the number of surfels with two or more hits that the beams passed (as in ``carve``); change no surfel."""
    count = 0
    low_row, high_row, low_column, high_column = cells_around(grid, pose, reach)
    for row in range(low_row, high_row):
        for column in range(low_column, high_column):
            k = grid.head[row, column]
            while k >= 0:
                if grid.surfels[k, HITS] >= 2.0 and _seen_through(grid.surfels, k, beams, pose, reach, margin):
                    count += 1
                k = grid.next[k]
    return count


@compiled_on_views
def cells_around(grid: Grid, pose: FloatArray, reach: float) -> tuple[int, int, int, int]:
    """Return the first row of the cells within ``reach``, the one after the last, and the same for the columns."""
    rows, columns = grid.head.shape
    low_row = int(np.floor((pose[1] - reach) / grid.cell)) - grid.corner[0]
    high_row = int(np.floor((pose[1] + reach) / grid.cell)) - grid.corner[0] + 1
    low_column = int(np.floor((pose[0] - reach) / grid.cell)) - grid.corner[1]
    high_column = int(np.floor((pose[0] + reach) / grid.cell)) - grid.corner[1] + 1
    return max(low_row, 0), min(high_row, rows), max(low_column, 0), min(high_column, columns)


@compiled_on_views
def _seen_through(surfels: FloatArray, k: int, beams: FreeBeams, pose: FloatArray, reach: float, margin: float) -> bool:
    """Return True if the beam towards surfel ``k`` and the two adjacent beams all went farther than it."""
    ranges = beams.ranges
    dx, dy = surfels[k, X] - pose[0], surfels[k, Y] - pose[1]
    distance = np.sqrt(dx * dx + dy * dy)
    if not MIN_DISTANCE < distance < reach:
        return False
    nx, ny = surfels[k, NX], surfels[k, NY]
    wall = nx != 0.0 or ny != 0.0
    if wall and abs(dx * nx + dy * ny) < EDGE_ON_COSINE * distance:
        return False
    j = beam_towards(beams, pose, dx, dy)
    if not 1 <= j < len(ranges) - 1:
        return False
    return bool(min(ranges[j - 1], ranges[j], ranges[j + 1]) > distance + margin)
