"""Marks one scan in a grid of cells: the area spanned by its beams is free, its echoes are walls.

The area is the polygon from the sensor along the ends of the beams and back. It is filled row by row: where an edge
crosses the middle line of a row, a bit of the cell to the right changes, and between an odd and an even change the row
is inside. So a cell counts once, however many beams run through it. All lengths are in cells.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled_on_views
from slam.pose import FloatArray

UNKNOWN, FREE, WALL = 0, 1, 2
_EDGE: Final = 0x80
"""Bit that flips at an edge; no cell keeps it."""


@compiled_on_views
def measure_seen(ranges: FloatArray, range_max: float, seen: FloatArray) -> None:
    """Write how far each beam saw, metres (N,): ``seen_ranges``."""
    last = len(ranges) - 1
    for j in range(len(ranges)):
        seen[j] = ranges[j] if abs(ranges[j]) < np.inf else 0.0
        if ranges[j] == np.inf and ranges[max(j - 1, 0)] == np.inf and ranges[min(j + 1, last)] == np.inf:
            seen[j] = range_max


@compiled_on_views
def mark_scan(
    cells: NDArray[np.uint8], x: float, y: float, ends: FloatArray, echoes: NDArray[np.bool_], whole_turn: bool
) -> int:
    """Mark cells spanned by the beams from (x, y) as FREE, and those with echoes as WALL.

    Returns how many were UNKNOWN. ``cells`` (rows, columns) is written to, row along y. ``ends`` (2, N) are x, y of the
    ends of the beams, in counter-clockwise order; the end of a beam that saw nothing is (x, y). With ``whole_turn`` the
    last beam is next to the first. A cell once seen as WALL stays one. Cells outside the grid are ignored.
    """
    last = ends.shape[1] - 1
    x0, y0 = (ends[0, last], ends[1, last]) if whole_turn else (x, y)
    low_x, high_x, low_y, high_y = x0, x0, y0, y0
    for j in range(last + 1):
        x1, y1 = ends[0, j], ends[1, j]
        _cross_rows(cells, x0, y0, x1, y1)
        low_x, high_x, low_y, high_y = min(low_x, x1), max(high_x, x1), min(low_y, y1), max(high_y, y1)
        x0, y0 = x1, y1
    if not whole_turn:
        _cross_rows(cells, x0, y0, x, y)
    rows, columns = cells.shape
    first_row, stop_row = max(_next_middle(low_y), 0), min(_next_middle(high_y), rows)
    first, stop = max(_next_middle(low_x) - 1, 0), min(_next_middle(high_x) + 2, columns)  # one more, for rounding
    found = 0
    for row in range(first_row, stop_row):
        found += _fill(cells[row, first:stop])
    return found + _mark_echoes(cells, ends, echoes)


@compiled_on_views
def _next_middle(place: float) -> int:
    """Return the index of the first cell whose middle is not before this position."""
    return int(np.ceil(place - 0.5))


@compiled_on_views
def _cross_rows(cells: NDArray[np.uint8], x0: float, y0: float, x1: float, y1: float) -> None:
    """Flip the bit of the first cell behind an edge in each row whose middle line it crosses."""
    begin, end = _next_middle(y0), _next_middle(y1)
    if begin == end:
        return
    slope = (x1 - x0) / (y1 - y0)
    for row in range(max(min(begin, end), 0), min(max(begin, end), cells.shape[0])):
        column = max(_next_middle(x0 + (row + 0.5 - y0) * slope), 0)
        if column < cells.shape[1]:
            cells[row, column] ^= _EDGE


@compiled_on_views
def _fill(row: NDArray[np.uint8]) -> int:
    """Mark the cells inside as FREE, and clear the bits of the edges; return how many were UNKNOWN."""
    found = inside = 0
    for column in range(len(row)):
        cell = int(row[column])
        inside ^= cell >> 7
        cell &= ~_EDGE
        found += inside & (cell == UNKNOWN)
        row[column] = max(cell, inside)
    return found


@compiled_on_views
def _mark_echoes(cells: NDArray[np.uint8], ends: FloatArray, echoes: NDArray[np.bool_]) -> int:
    found = 0
    for j in range(len(echoes)):
        row, column = int(np.floor(ends[1, j])), int(np.floor(ends[0, j]))
        if echoes[j] and 0 <= row < cells.shape[0] and 0 <= column < cells.shape[1]:
            found += cells[row, column] == UNKNOWN
            cells[row, column] = WALL
    return found
