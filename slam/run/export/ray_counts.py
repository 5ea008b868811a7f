"""What the beams of scans went through and where they ended, counted in a grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.pose import FloatArray

CountArray = NDArray[np.int32]


@compiled
def count_rays(
    passes: CountArray, hits: CountArray, corner: FloatArray, cell: float, origin: FloatArray, ends: FloatArray,
    echoes: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Add the beams from ``origin`` (2,) to ``ends`` (N, 2) to the counts (rows, columns), which must hold them all.

    Each cell on the way counts a pass, but the one where an echo came from counts a hit. ``corner`` is the outer corner
    of cell [0, 0], metres, map frame. Cells are walked one border after another (Amanatides and Woo 1987).
    """
    x0, y0 = (origin[0] - corner[0]) / cell, (origin[1] - corner[1]) / cell
    for j in range(len(ends)):
        x1, y1 = (ends[j, 0] - corner[0]) / cell, (ends[j, 1] - corner[1]) / cell
        column, row = int(np.floor(x0)), int(np.floor(y0))
        last_column, last_row = int(np.floor(x1)), int(np.floor(y1))
        dx, dy = x1 - x0, y1 - y0
        step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
        t_x = (column + (step_x > 0) - x0) / dx if dx != 0.0 else np.inf
        t_y = (row + (step_y > 0) - y0) / dy if dy != 0.0 else np.inf
        for _ in range(abs(last_column - column) + abs(last_row - row)):
            passes[row, column] += 1
            if (t_x < t_y and column != last_column) or row == last_row:
                column += step_x
                t_x += step_x / dx
            else:
                row += step_y
                t_y += step_y / dy
        if echoes[j]:
            hits[row, column] += 1
        else:
            passes[row, column] += 1
