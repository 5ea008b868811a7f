"""The walls of the map: adjoining surfels on one line, where the evidence of beams shows wall."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.lines.segments import IntArray
from slam.mapping.surfel_grid import AXIS, INFORMATION, NX, NY, PIECES, PIECES_PER_CELL, X, Y
from slam.mapping.wall_corners import meet_at_corners
from slam.mapping.wall_doubles import without_doubles
from slam.pose import FloatArray

Evidence = NDArray[np.int8]
W, WX, WY, WXX, WXY, WYY = range(6)
"""Weighted sums from which a line is fitted: of 1, x, y, xx, xy and yy."""
LINE_NX, LINE_NY, LINE_X, LINE_Y = range(4)
"""Columns of lines (M, 4): normal away from the sensor, and a point; map frame."""
NEIGHBOURS = 2  # cells to each side in which a wall may continue
MAX_GAP = 2.2  # cells, the largest gap along a wall between its surfels
MAX_OFFSET = 0.05  # metres, the largest distance of a surfel from the wall that it joins
WALL_COSINE = 0.9  # least cosine between the normals of a surfel and of its wall
SIGMA_FLOOR = 0.01  # metres, the least standard deviation of a surfel
WALL: Final = 2
"""Echoes minus passes from which a bin counts as wall."""
BIN: Final = 0.025
"""Length of the bins along a wall in which the pieces of its surfels are summed, metres."""
MAX_UNKNOWN: Final = 0.2
"""Largest part without any beam that a wall spans, metres."""
ALONG_AXIS: Final = 0.5
"""Least cosine between a wall and the axis along which the pieces of a surfel are cut."""
SHORTEST: Final = 0.2
"""Least length of a wall, metres."""
MIN_SUPPORT: Final = 1.0
"""Least length of a wall times its mean count, metres: a short one must be seen more often."""


def wall_segments(surfels: FloatArray, evidence: Evidence, cell: float) -> FloatArray:
    """Return start and end of the walls of these surfels (S, 8), (M, 2, 2): [wall, start or end, x or y], metres.

    They are in the map frame. ``evidence`` (S, 9) is that of their pieces. Walls are grown in the order of their most
    certain surfel.
    """
    known = ((surfels[:, NX] != 0.0) | (surfels[:, NY] != 0.0)) & (evidence[:, :PIECES] >= WALL).any(axis=1)
    surest_first = np.flatnonzero(known)[np.argsort(-surfels[known, INFORMATION], kind="stable")]
    surfels, evidence = surfels[surest_first], evidence[surest_first]
    columns_rows = np.floor(surfels[:, :2] / cell).astype(np.int64)
    columns_rows += NEIGHBOURS + 1 - columns_rows.min(axis=0, initial=0)
    columns, rows = columns_rows.max(axis=0, initial=0) + NEIGHBOURS + 2
    wall_of = _wall_numbers(surfels, columns_rows, np.full((rows, columns), -1, np.int64), cell)
    by_wall = np.argsort(wall_of, kind="stable")
    begins = np.searchsorted(wall_of[by_wall], np.arange(wall_of.max(initial=-1) + 2))
    ends, support = _spans_of_walls(surfels[by_wall], evidence[by_wall], begins, cell)
    return meet_at_corners(without_doubles(ends, support, SHORTEST))


@compiled
def _spans_of_walls(
    surfels: FloatArray, evidence: Evidence, begins: IntArray, cell: float
) -> tuple[FloatArray, FloatArray]:
    """Return the parts of all lines that are wall, (M, 2, 2), and the support of each, (M,)."""
    ends, support = np.empty((PIECES * len(surfels), 2, 2)), np.empty(PIECES * len(surfels))
    line, count = np.empty(4), 0
    for m in range(len(begins) - 1):
        members, seen = surfels[begins[m] : begins[m + 1]], evidence[begins[m] : begins[m + 1]]
        _fit(members, line)
        low, counts = _along(members, seen, line, cell)
        count = _write_spans(low, counts, line, ends, support, count)
    return ends[:count], support[:count]


@compiled
def _along(members: FloatArray, evidence: Evidence, line: FloatArray, cell: float) -> tuple[float, IntArray]:
    """Return the start of the bins along the line, and their counts; 0 without a beam."""
    low, high = np.inf, -np.inf
    spans = np.empty((len(members), PIECES, 2))
    for k in range(len(members)):
        along_y = evidence[k, AXIS] > 0
        slope, middle = (line[LINE_NX], line[LINE_Y]) if along_y else (-line[LINE_NY], line[LINE_X])
        begin = (np.floor((members[k, Y] if along_y else members[k, X]) / cell) - 0.5) * cell - middle
        spans[k] = 0.0
        for p in range(PIECES if abs(slope) > ALONG_AXIS else 0):
            a = (begin + p * cell / PIECES_PER_CELL) / slope
            b = (begin + (p + 1) * cell / PIECES_PER_CELL) / slope
            spans[k, p, 0], spans[k, p, 1] = min(a, b), max(a, b)
            low, high = min(low, spans[k, p, 0]), max(high, spans[k, p, 1])
    counts = np.zeros(max(int((high - low) / BIN), 0) + 2, np.int64)
    for k in range(len(members)):
        for p in range(PIECES):
            n = evidence[k, p]
            if n != 0 and spans[k, p, 0] < spans[k, p, 1]:
                first = int((spans[k, p, 0] - low) / BIN + 0.5)
                for i in range(first, max(int((spans[k, p, 1] - low) / BIN + 0.5), first + 1)):
                    counts[i] = n if counts[i] == 0 else max(counts[i], n)
    return low, counts


@compiled_on_views
def _write_spans(
    low: float, counts: IntArray, line: FloatArray, ends: FloatArray, support: FloatArray, count: int
) -> int:
    """Write the parts of a line that are wall, joined over bins without beams; return their number."""
    begin = last = -1
    weight, unknown = 0.0, 0.0
    for i in range(len(counts) + 1):
        if i < len(counts) and counts[i] >= WALL:
            if begin < 0:
                begin, weight = i, 0.0
            last, unknown = i, 0.0
            weight += counts[i] * BIN
            continue
        if i < len(counts) and counts[i] == 0:
            unknown += BIN
        if begin >= 0 and (i >= len(counts) or counts[i] < 0 or unknown > MAX_UNKNOWN):
            if (last + 1 - begin) * BIN >= SHORTEST and weight >= MIN_SUPPORT:
                for side in range(2):
                    t = low + (begin if side == 0 else last + 1) * BIN
                    ends[count, side, 0] = line[LINE_X] - t * line[LINE_NY]
                    ends[count, side, 1] = line[LINE_Y] + t * line[LINE_NX]
                support[count] = weight
                count += 1
            begin = -1
    return count


@compiled
def _wall_numbers(surfels: FloatArray, columns_rows: IntArray, head: IntArray, cell: float) -> IntArray:
    """Return the wall of each surfel, (S,); ``head`` has a -1 for every cell, and becomes the first surfel of each."""
    following, wall_of = np.empty(len(surfels), np.int64), np.full(len(surfels), -1, np.int64)
    for k in range(len(surfels)):
        column, row = columns_rows[k, 0], columns_rows[k, 1]
        following[k] = head[row, column]
        head[row, column] = k
    queue = np.empty(len(surfels), np.int64)
    count = 0
    for seed in range(len(surfels)):
        if wall_of[seed] < 0:
            _grow_one(surfels, columns_rows, head, following, cell, wall_of, queue, seed, count)
            count += 1
    return wall_of


@compiled
def _grow_one(
    surfels: FloatArray, columns_rows: IntArray, head: IntArray, following: IntArray, cell: float, wall_of: IntArray,
    queue: IntArray, seed: int, number: int,
) -> None:  # fmt: skip
    """Grow one wall from its most certain surfel over its neighbours; ``queue`` (S,) is scratch."""
    sums = np.zeros(6)
    _include(sums, surfels[seed], surfels[seed, X], surfels[seed, Y])
    wall_of[seed], queue[0] = number, seed
    begin, end = 0, 1
    while begin < end:
        at = queue[begin]
        begin += 1
        column, row = columns_rows[at, 0], columns_rows[at, 1]
        for i in range(row - NEIGHBOURS, row + NEIGHBOURS + 1):
            for j in range(column - NEIGHBOURS, column + NEIGHBOURS + 1):
                k = head[i, j]
                while k >= 0:
                    if wall_of[k] < 0 and _continues(sums, surfels[seed], surfels[at], surfels[k], cell):
                        wall_of[k], queue[end] = number, k
                        end += 1
                        _include(sums, surfels[k], surfels[seed, X], surfels[seed, Y])
                    k = following[k]


@compiled_on_views
def _include(sums: FloatArray, s: FloatArray, x0: float, y0: float) -> None:
    """Add a surfel to the sums about (x0, y0)."""
    w = 1.0 / (1.0 / s[INFORMATION] + SIGMA_FLOOR * SIGMA_FLOOR)
    x, y = s[X] - x0, s[Y] - y0
    sums[W] += w
    sums[WX] += w * x
    sums[WY] += w * y
    sums[WXX] += w * x * x
    sums[WXY] += w * x * y
    sums[WYY] += w * y * y


@compiled_on_views
def _line(sums: FloatArray, nx: float, ny: float) -> tuple[float, float, float, float]:
    """Return normal and mean of the best line; the normal is on the side of (nx, ny), or equal for a single point."""
    mx, my = sums[WX] / sums[W], sums[WY] / sums[W]
    xx, xy, yy = sums[WXX] - mx * sums[WX], sums[WXY] - mx * sums[WY], sums[WYY] - my * sums[WY]
    if xx + yy < 1e-3 * sums[W]:  # shorter than its uncertainty
        return nx, ny, mx, my
    half = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    lx, ly = -np.sin(half), np.cos(half)
    side = 1.0 if lx * nx + ly * ny >= 0.0 else -1.0
    return side * lx, side * ly, mx, my


@compiled_on_views
def _continues(sums: FloatArray, seed: FloatArray, at: FloatArray, s: FloatArray, cell: float) -> bool:
    """Return True if the surfel ``s`` continues the wall at its surfel ``at``."""
    nx, ny, mx, my = _line(sums, seed[NX], seed[NY])
    if s[NX] * nx + s[NY] * ny < WALL_COSINE:
        return False
    if abs((s[X] - seed[X] - mx) * nx + (s[Y] - seed[Y] - my) * ny) > MAX_OFFSET:
        return False
    dx, dy = s[X] - at[X], s[Y] - at[Y]
    return bool(dx * dx + dy * dy < (MAX_GAP * cell) ** 2)


@compiled
def _fit(members: FloatArray, line: FloatArray) -> None:
    """Write the line (4,) that fits best to the surfels (K, 7) of one wall."""
    sums = np.zeros(6)
    x0, y0 = members[0, X], members[0, Y]
    for k in range(len(members)):
        _include(sums, members[k], x0, y0)
    nx, ny, mx, my = _line(sums, members[0, NX], members[0, NY])
    line[LINE_NX], line[LINE_NY], line[LINE_X], line[LINE_Y] = nx, ny, x0 + mx, y0 + my
