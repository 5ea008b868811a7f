"""Exact rays in a plan of polygons: the segments lie in the cells of a grid, and a ray walks from cell to cell."""

from collections.abc import Sequence
from math import floor, inf
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.pose import FloatArray

CELL: Final = 0.25
"""Side of a cell, metres ..."""
MOST_CELLS: Final = 1024
"""... or more, so that a large plan has at most this many along a side."""


class PlanGrid(NamedTuple):
    """Segments of outlines, and which of them pass each cell."""

    segments: FloatArray
    """(M, 4): x, y of one end, and from there to the other."""
    corner: FloatArray
    """(2,): where cell (0, 0) begins, metres."""
    cell: float
    shape: tuple[int, int]
    """Cells along x and along y."""
    first: NDArray[np.int64]
    """(cells + 1,): cell (i, k) has the ``listed`` from first[i * shape[1] + k] up to the next entry."""
    listed: NDArray[np.int64]
    """Rows of ``segments``."""


def outline_edges(outline: FloatArray) -> FloatArray:
    """Edges (N, 4) of a closed outline (N, 2): x, y of one end, and from there to the other."""
    return np.hstack([outline, np.roll(outline, -1, axis=0) - outline])


def plan_grid(outlines: Sequence[FloatArray]) -> PlanGrid:
    """Make the grid of closed outlines (N, 2), metres."""
    segments = np.concatenate([np.empty((0, 4)), *map(outline_edges, outlines)])
    if not len(segments):
        return PlanGrid(segments, np.zeros(2), CELL, (0, 0), np.zeros(1, np.int64), np.zeros(0, np.int64))
    corner = segments[:, :2].min(axis=0) - CELL / 2.0  # nothing lies on the rim
    size = segments[:, :2].max(axis=0) + CELL / 2.0 - corner
    cell = max(CELL, float(size.max()) / MOST_CELLS)
    shape = (int(size[0] / cell) + 1, int(size[1] / cell) + 1)
    first, listed = _fill(segments, corner, cell, shape)
    return PlanGrid(segments, corner, cell, shape, first, listed)


@compiled
def _fill(
    segments: FloatArray, corner: FloatArray, cell: float, shape: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """``first`` and ``listed``: counted in one pass, written in the second.

    A segment is listed where its line is within half a cell's diagonal (and a hundredth) of the middle of the cell.
    """
    first = np.zeros(shape[0] * shape[1] + 1, np.int64)
    listed = np.zeros(0, np.int64)
    near = 0.7171 * cell
    for writing in range(2):
        for row in range(len(segments)):
            x, y, dx, dy = segments[row] - np.array([corner[0], corner[1], 0.0, 0.0])
            length = np.sqrt(dx * dx + dy * dy)
            for i in range(int((min(x, x + dx)) / cell), int((max(x, x + dx)) / cell) + 1):
                for k in range(int((min(y, y + dy)) / cell), int((max(y, y + dy)) / cell) + 1):
                    across = ((i + 0.5) * cell - x) * dy - ((k + 0.5) * cell - y) * dx
                    if abs(across) > near * length:
                        continue
                    at = i * shape[1] + k
                    if writing:
                        listed[first[at]] = row
                        first[at] += 1
                    else:
                        first[at + 1] += 1
        if writing:
            first[1:] = first[:-1].copy()
            first[0] = 0
        else:
            first = np.cumsum(first)
            listed = np.empty(first[-1], np.int64)
    return first, listed


@compiled
def cast_in_plan(
    origins: FloatArray, directions: FloatArray, reach: float, segments: FloatArray, corner: FloatArray, cell: float,
    shape: tuple[int, int], first: NDArray[np.int64], listed: NDArray[np.int64],
) -> FloatArray:  # fmt: skip
    """Metres to the nearest segment along each ray (N, 2), (N, 2); inf where none is within ``reach``.

    Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", 1987: the ray is in a cell until it has gone
    ``out_x`` or ``out_y`` metres, whichever is less, and a hit before that is the nearest there is.
    """
    ranges = np.full(len(origins), inf)
    for j in range(len(origins)):
        ox, oy, dx, dy = origins[j, 0], origins[j, 1], directions[j, 0], directions[j, 1]
        x, y = (ox - corner[0]) / cell, (oy - corner[1]) / cell
        entry = 0.0  # where the ray enters the grid, in cells
        for at, step, end in ((x, dx, shape[0]), (y, dy, shape[1])):
            if step != 0.0:
                entry = max(entry, min(-at / step, (end - at) / step))
        inwards = entry + 1e-9 if entry > 0.0 else 0.0
        i, k = floor(x + inwards * dx), floor(y + inwards * dy)
        turn_x, turn_y = 1 if dx > 0.0 else -1, 1 if dy > 0.0 else -1
        out_x = (i + (dx > 0.0) - x) / dx * cell if dx != 0.0 else inf
        out_y = (k + (dy > 0.0) - y) / dy * cell if dy != 0.0 else inf
        nearest, entered = reach, entry * cell
        while 0 <= i < shape[0] and 0 <= k < shape[1] and entered <= nearest:
            for at in range(first[i * shape[1] + k], first[i * shape[1] + k + 1]):
                sx, sy, ux, uy = segments[listed[at]]
                det = dx * uy - dy * ux
                if det == 0.0:
                    continue
                along = ((sx - ox) * uy - (sy - oy) * ux) / det
                share = ((sx - ox) * dy - (sy - oy) * dx) / det
                if 0.0 <= along <= nearest and 0.0 <= share <= 1.0:
                    nearest = along
                    ranges[j] = along
            if out_x < out_y:
                entered, i, out_x = out_x, i + turn_x, out_x + abs(cell / dx)
            else:
                entered, k, out_y = out_y, k + turn_y, out_y + abs(cell / dy)
    return ranges
