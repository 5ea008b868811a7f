"""Occupancy grids of many robots: cells that a scan sees are marked, and a square around the robot is cut out."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled_on_views
from slam.env.scan_fill import UNKNOWN, mark_scan, measure_seen
from slam.pose import FloatArray

UNIT: Final = float(1 << 32)
"""Fixed-point steps per cell."""


@compiled_on_views
def mark_ranges(
    cells: NDArray[np.uint8], x: float, y: float, c: float, s: float, beams: FloatArray,
    scan: FloatArray, range_max: float, cell: float, whole_turn: bool, ends: FloatArray, echoes: NDArray[np.bool_],
) -> int:  # fmt: skip
    """Mark the cells that one scan sees, as ``OccupancyGrid.add_scan`` does; return how many were unknown before.

    x and y are the sensor's position, in cells; c and s are cosine and sine of the base's heading; ``beams`` (2, B) are
    the unit vectors of the beams in the base frame. ``scan`` (B,), ``ends`` (2, B) and ``echoes`` (B,) are overwritten.
    """
    for j in range(len(scan)):
        echoes[j] = abs(scan[j]) < np.inf
    measure_seen(scan, range_max, ends[0])
    for j in range(len(scan)):
        length = ends[0, j] / cell
        ends[0, j] = x + length * (c * beams[0, j] - s * beams[1, j])
        ends[1, j] = y + length * (s * beams[0, j] + c * beams[1, j])
    return mark_scan(cells, x, y, ends, echoes, whole_turn)


@compiled_on_views
def crop(cells: NDArray[np.uint8], x: float, y: float, c: float, s: float, square: NDArray[np.uint8]) -> None:
    """Cut out the square (n, n) around the place x, y, in cells, heading up: row 0 lies ahead, column 0 to the left.

    Positions are fixed-point numbers with 2^32 steps per cell. The grey levels 0, 127 and 255 are those of
    ``map_view``.
    """
    rows, columns = np.uint64(cells.shape[0]), np.uint64(cells.shape[1])
    middle = 0.5 * len(square) - 0.5
    step_x, step_y = np.int64(np.rint(s * UNIT)), np.int64(np.rint(-c * UNIT))
    for row in range(len(square)):
        ahead, line = middle - row, square[row]
        at_x = np.int64((x + c * ahead - s * middle) * UNIT)
        at_y = np.int64((y + s * ahead + c * middle) * UNIT)
        for column in range(len(line)):
            i, k = np.uint64(at_y >> 32), np.uint64(at_x >> 32)  # a negative index becomes a large one
            what = cells[i, k] if (i < rows) & (k < columns) else np.uint8(UNKNOWN)
            line[column] = 127 * what + (what >> 1)
            at_x, at_y = at_x + step_x, at_y + step_y
