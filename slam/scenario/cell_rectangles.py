"""Occupied cells of a grid, merged into few rectangles."""

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled


@compiled
def _tallest(occupied: NDArray[np.bool_], row: int, column: int, columns: int, limit: int) -> int:
    """Count the rows from ``row`` on, at most ``limit``, that are occupied all along ``columns`` columns."""
    for rows in range(limit):
        for k in range(column, column + columns):
            if not occupied[row + rows, k]:
                return rows
    return limit


@compiled
def _widest(occupied: NDArray[np.bool_], row: int, column: int, rows: int, limit: int) -> int:
    """Count the columns from ``column`` on, at most ``limit``, that are occupied all along ``rows`` rows."""
    for columns in range(limit):
        for k in range(row, row + rows):
            if not occupied[k, column + columns]:
                return columns
    return limit


@compiled
def merge_cells(occupied: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Rectangles (N, 4) of row, column, rows, columns that cover the occupied cells, each cell at least once.

    Greedy: from each cell that is not yet covered, in reading order, the larger of the two rectangles that grow as far
    as they can along the row first, or along the column first.
    """
    height, width = occupied.shape
    covered = np.zeros_like(occupied)
    found = np.empty((occupied.sum(), 4), np.int64)
    count = 0
    for row in range(height):
        for column in range(width):
            if not occupied[row, column] or covered[row, column]:
                continue
            wide = _widest(occupied, row, column, 1, width - column)
            wide_rows = _tallest(occupied, row, column, wide, height - row)
            rows = _tallest(occupied, row, column, 1, height - row)
            columns = _widest(occupied, row, column, rows, width - column)
            if wide * wide_rows >= rows * columns:
                rows, columns = wide_rows, wide
            covered[row : row + rows, column : column + columns] = True
            found[count] = row, column, rows, columns
            count += 1
    return found[:count].copy()
