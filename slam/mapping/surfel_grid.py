"""The grid of surfels as plain arrays for compiled functions, and its enlargement."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.errors import InputError
from slam.limits import MAP_CELLS
from slam.lines.segments import IntArray
from slam.pose import FloatArray

X, Y, NX, NY, INFORMATION, HITS, MISSES, BORN = range(8)
"""Columns of surfels (S, 8): centre (m, map frame), unit normal away from the sensor (0, 0 for a cluster of points),
information along the normal (m^-2), number of hits, number of misses since, and ``path_length`` at its first hit.
Facets have the same first four columns."""
COLUMNS: Final = 8
PIECES_PER_CELL: Final = 4
PIECES: Final = 2 * PIECES_PER_CELL
AXIS: Final = PIECES
"""Columns of evidence (S, 9): a count for each piece of the surfel's line, see wall_evidence.py, and 1 if the pieces
are cut along y, 0 along x."""
TAKEN, FREE, ALIVE = range(3)
"""Indices in ``Grid.counts``: used rows, first free row, surfels alive."""
MARGIN: Final = 64
"""Cells by which the grid is larger than necessary."""


class Grid(NamedTuple):
    """Surfels in linked lists, one for each cell."""

    head: NDArray[np.int32]
    """(rows, columns): the first surfel of each cell, -1 for none."""
    next: NDArray[np.int32]
    """(S,): the next surfel of the same cell, or of the free list, -1 for none."""
    surfels: FloatArray
    evidence: NDArray[np.int8]
    corner: IntArray
    """(2,): row and column of ``head[0, 0]`` in the map frame."""
    cell: float
    """Side of a cell, metres."""
    counts: IntArray
    """(3,): number of rows of ``surfels`` ever used, the first of the free list or -1, and the number of surfels
    alive."""
    path_length: float
    """Path length of the sensor while this map was made, the sum of metres and radians."""


def empty_grid(cell: float) -> Grid:
    """Make a grid around the origin without a surfel; ``cell`` in metres."""
    return Grid(
        head=np.full((2 * MARGIN, 2 * MARGIN), -1, np.int32),
        next=np.full(1024, -1, np.int32),
        surfels=np.zeros((1024, COLUMNS)),
        evidence=np.zeros((1024, PIECES + 1), np.int8),
        corner=np.array([-MARGIN, -MARGIN]),
        cell=cell,
        counts=np.array([0, -1, 0]),
        path_length=0.0,
    )


def with_room(grid: Grid, low: IntArray, high: IntArray, more: int) -> Grid:
    """Return the grid, enlarged if necessary for ``more`` surfels in the cells ``low`` to ``high``, row, column (2,).

    InputError if it would have more cells than the limit.
    """
    shape = np.array(grid.head.shape)
    if (low < grid.corner).any() or (high >= grid.corner + shape).any():
        corner = np.minimum(grid.corner, low - MARGIN)
        rows, columns = np.maximum(grid.corner + shape, high + MARGIN) - corner
        if excess := MAP_CELLS.excess(float(rows) * float(columns), f"of {grid.cell:g} m in the map"):
            raise InputError(f"the map would have {excess}")
        head = np.full((rows, columns), -1, np.int32)
        row, column = grid.corner - corner
        head[row : row + shape[0], column : column + shape[1]] = grid.head
        grid = grid._replace(head=head, corner=corner)
    if grid.counts[TAKEN] + more > len(grid.surfels):
        size = 2 * len(grid.surfels) + more
        surfels, following = np.zeros((size, COLUMNS)), np.full(size, -1, np.int32)
        evidence = np.zeros((size, PIECES + 1), np.int8)
        surfels[: len(grid.surfels)], following[: len(grid.next)] = grid.surfels, grid.next
        evidence[: len(grid.evidence)] = grid.evidence
        grid = grid._replace(surfels=surfels, next=following, evidence=evidence)
    return grid


@compiled
def room_needed(facets: FloatArray, pose: FloatArray, cell: float) -> tuple[IntArray, IntArray, int]:
    """Return the least and the greatest row and column (2,) that facets (F, 7) from ``pose`` (3,) touch.

    The third value is an upper bound of the number of surfels for them and the walls between them.
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    low_x = low_y = np.inf
    high_x = high_y = -np.inf
    path = last_x = last_y = 0.0
    for f in range(len(facets)):
        x, y = pose[0] + c * facets[f, X] - s * facets[f, Y], pose[1] + s * facets[f, X] + c * facets[f, Y]
        low_x, low_y, high_x, high_y = min(low_x, x), min(low_y, y), max(high_x, x), max(high_y, y)
        if f > 0:
            path += abs(x - last_x) + abs(y - last_y)
        last_x, last_y = x, y
    most = int(path * 2.0 / cell) + 2 * len(facets)
    low, high = np.empty(2, np.int64), np.empty(2, np.int64)
    low[0], low[1] = int(np.floor(low_y / cell)), int(np.floor(low_x / cell))
    high[0], high[1] = int(np.floor(high_y / cell)), int(np.floor(high_x / cell))
    return low, high, most
