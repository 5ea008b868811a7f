"""Which cells of a grid rays run through."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.pose import FloatArray

UNKNOWN, FREE, WALL = 0, 1, 2


@compiled
def mark_rays(
    cells: NDArray[np.uint8], x: float, y: float, headings: FloatArray, lengths: FloatArray, echoes: NDArray[np.bool_]
) -> int:
    """Mark what each ray from (x, y) runs through as FREE, and where an echo came from as WALL; how many were UNKNOWN.

    ``cells`` (rows, columns) is written to, row along y; x, y and ``lengths`` (N,) are in cells, ``headings`` (N,) in
    radians. A ray of length 0 or less marks nothing. A cell once seen as WALL stays one. Outside there is nothing.
    """
    found = 0
    for k in range(len(headings)):
        if lengths[k] > 0.0:
            found += _march(cells, x, y, np.cos(headings[k]), np.sin(headings[k]), lengths[k], echoes[k])
    return found


@compiled
def _march(cells: NDArray[np.uint8], x: float, y: float, dx: float, dy: float, length: float, echo: bool) -> int:
    """One ray, from border to border of the cells it crosses (Amanatides and Woo, 1987)."""
    column, row = int(np.floor(x)), int(np.floor(y))
    step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    per_x, per_y = 1.0 / max(abs(dx), 1e-12), 1.0 / max(abs(dy), 1e-12)  # along the ray, from border to border
    at_x = (column + 1 - x if dx > 0.0 else x - column) * per_x
    at_y = (row + 1 - y if dy > 0.0 else y - row) * per_y
    found = 0
    while min(at_x, at_y) < length:
        found += _mark(cells, row, column, FREE)
        if at_x < at_y:
            at_x += per_x
            column += step_x
        else:
            at_y += per_y
            row += step_y
    return found + _mark(cells, row, column, WALL if echo else FREE)


@compiled
def _mark(cells: NDArray[np.uint8], row: int, column: int, what: int) -> int:
    if row < 0 or column < 0 or row >= cells.shape[0] or column >= cells.shape[1]:
        return 0
    before = cells[row, column]
    cells[row, column] = max(before, what)
    return 1 if before == UNKNOWN else 0
