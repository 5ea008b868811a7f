"""The occupancy grids of many robots: what a scan shows is marked, and a square around the robot is cut out."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled_on_views
from slam.env.occupancy_grid import FREE, WALL, march
from slam.pose import FloatArray

GREY_FREE: Final = 127
GREY_WALL: Final = 255


@compiled_on_views
def mark_scan(
    cells: NDArray[np.uint8], x: float, y: float, c: float, s: float, beams: FloatArray,
    scan: FloatArray, range_max: float, cell: float,
) -> int:  # fmt: skip
    """Mark what the beams of one scan ran through and met; how many cells were unknown before.

    x and y are the sensor's place, in cells, c and s are cosine and sine of the base's heading, ``beams`` (2, B) where
    the beams point from there. How far a beam saw is what ``seen_ranges`` says.
    """
    found, last = 0, len(scan) - 1
    for j in range(len(scan)):
        echo = abs(scan[j]) < np.inf
        seen = scan[j] if echo else 0.0
        if scan[j] == np.inf and scan[max(j - 1, 0)] == np.inf and scan[min(j + 1, last)] == np.inf:
            seen = range_max
        if seen > 0.0:
            dx, dy = c * beams[0, j] - s * beams[1, j], s * beams[0, j] + c * beams[1, j]
            found += march(cells, x, y, dx, dy, seen / cell, echo)
    return found


@compiled_on_views
def crop(cells: NDArray[np.uint8], x: float, y: float, c: float, s: float, square: NDArray[np.uint8]) -> None:
    """Cut out the square (n, n) around the place x, y, in cells, heading up: row 0 lies ahead, column 0 to the left."""
    size = len(square)
    for row in range(size):
        ahead = size / 2.0 - 0.5 - row
        for column in range(size):
            left = size / 2.0 - 0.5 - column
            i, k = int(np.floor(y + s * ahead + c * left)), int(np.floor(x + c * ahead - s * left))
            inside = 0 <= i < cells.shape[0] and 0 <= k < cells.shape[1]
            what = cells[i, k] if inside else 0
            square[row, column] = GREY_WALL if what == WALL else (GREY_FREE if what == FREE else 0)
