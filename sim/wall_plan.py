"""The walls of one or several worlds in the plane, listed for each cell of the floor. Metres."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.pose import FloatArray

CELL: Final = 2.0
"""Least side of a cell, metres."""
MAX_CELLS: Final = 256
"""Largest number of cells along a side; large worlds have larger cells."""
SLACK: Final = 0.5
"""The list of a cell is valid for rays that start this far outside of it, metres."""


class WallPlan(NamedTuple):
    """Walls of W worlds.

    Cell n has the ``listed`` walls from ``first[n]`` up to ``first[n + 1]``. Cell (i, k) of world w has the number n =
    ``offset[w] + i * shape[w, 1] + k``; the last cell of a world is followed by one more, with all its walls.
    """

    walls: FloatArray
    """(M, 4): x, y of one end, and the vector to the other; world after world."""
    corner: FloatArray
    """(W, 2): corner of cell (0, 0), metres."""
    cell: FloatArray
    """(W,): side of a cell."""
    shape: NDArray[np.int64]
    """(W, 2): cells along x and along y."""
    offset: NDArray[np.int64]
    """(W,): number of cell (0, 0)."""
    first: NDArray[np.int64]
    """(cells + 1,)."""
    listed: NDArray[np.int32]
    """Rows of ``walls``: for each cell, the walls within ``reach`` of the cell enlarged by SLACK on all sides."""
    reach: float


def outline_edges(outline: FloatArray) -> FloatArray:
    """Return the edges (N, 4) of a closed outline (N, 2): x, y of one end, and the vector to the other."""
    return np.hstack([outline, np.roll(outline, -1, axis=0) - outline])


def wall_plan(worlds: Sequence[Sequence[FloatArray]], reach: float) -> WallPlan:
    """Make the plan of these worlds, each given as closed outlines (N, 2), for rays of this length at most."""
    walls = [np.concatenate([np.empty((0, 4)), *map(outline_edges, outlines)]) for outlines in worlds]
    together = np.concatenate(walls)
    begins = np.cumsum([0, *map(len, walls)])
    corner, cell, shape = zip(*(_cells(rows, reach) for rows in walls), strict=True)
    offset = np.cumsum([0, *(columns * rows + 1 for columns, rows in shape)])
    first = [np.zeros(1, np.int64)]
    listed = []
    for w in range(len(walls)):
        counts, rows = _walls_in_reach(together[begins[w] : begins[w + 1]], corner[w], cell[w], shape[w], reach)
        counts = np.append(counts, len(walls[w]))
        first.append(first[-1][-1] + np.cumsum(counts))
        listed += [rows + np.int32(begins[w]), np.arange(begins[w], begins[w + 1], dtype=np.int32)]
    return WallPlan(
        together, np.array(corner), np.array(cell), np.array(shape, np.int64), offset[:-1],
        np.concatenate(first), np.concatenate(listed), float(reach),
    )  # fmt: skip


def _cells(walls: FloatArray, reach: float) -> tuple[FloatArray, float, tuple[int, int]]:
    """Return corner, side and number of the cells that cover all positions within range of a wall.

    Without walls there is one cell.
    """
    if not len(walls) or not np.isfinite(reach):
        return np.full(2, -1e6), 2e6, (1, 1)
    ends = np.concatenate([walls[:, :2], walls[:, :2] + walls[:, 2:]])
    corner = ends.min(axis=0) - reach
    size = ends.max(axis=0) + reach - corner
    cell = max(CELL, float(size.max()) / MAX_CELLS)
    return corner, cell, (int(size[0] / cell) + 1, int(size[1] / cell) + 1)


@compiled
def _walls_in_reach(
    walls: FloatArray, corner: FloatArray, cell: float, shape: tuple[int, int], reach: float
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Count the walls within range of each cell in one pass, and list them in a second."""
    counts = np.zeros(shape[0] * shape[1], np.int64)
    listed = np.empty(0, np.int32)
    far = reach + SLACK + cell * np.sqrt(0.5)  # from the middle of the cell
    for writing in range(2):
        if writing:
            listed = np.empty(counts.sum(), np.int32)
            at = np.cumsum(counts) - counts
        for row in range(len(walls)):
            x, y, ux, uy = walls[row]
            i0, i1 = (min(x, x + ux) - far - corner[0]) / cell, (max(x, x + ux) + far - corner[0]) / cell
            k0, k1 = (min(y, y + uy) - far - corner[1]) / cell, (max(y, y + uy) + far - corner[1]) / cell
            for i in range(max(int(i0), 0), min(int(i1) + 1, shape[0])):
                for k in range(max(int(k0), 0), min(int(k1) + 1, shape[1])):
                    middle_x, middle_y = corner[0] + (i + 0.5) * cell, corner[1] + (k + 0.5) * cell
                    if squared_distance(x - middle_x, y - middle_y, ux, uy) <= far * far:
                        n = i * shape[1] + k
                        if writing:
                            listed[at[n]] = row
                            at[n] += 1
                        else:
                            counts[n] += 1
    return counts, listed


@compiled_on_views
def squared_distance(x: float, y: float, ux: float, uy: float) -> float:
    """Return the squared distance from the origin to the nearest point of the wall from (x, y) to (x + ux, y + uy)."""
    squared = ux * ux + uy * uy
    share = min(max(-(x * ux + y * uy) / squared, 0.0), 1.0) if squared > 0.0 else 0.0
    return float((x + share * ux) ** 2 + (y + share * uy) ** 2)


@compiled_on_views
def cell_near(plan: WallPlan, world: int, x: float, y: float, spread: float) -> int:
    """Return a cell that lists all walls within the plan's range of any position within ``spread`` metres of (x, y)."""
    columns, rows = plan.shape[world, 0], plan.shape[world, 1]
    if spread > SLACK:
        return int(plan.offset[world] + columns * rows)
    i = int(np.floor((x - plan.corner[world, 0]) / plan.cell[world]))
    k = int(np.floor((y - plan.corner[world, 1]) / plan.cell[world]))
    i, k = min(max(i, 0), columns - 1), min(max(k, 0), rows - 1)  # the nearest cell, if outside
    return int(plan.offset[world] + i * rows + k)
