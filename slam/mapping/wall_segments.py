"""The walls of the map: surfels that lie on one line and touch are one segment."""

import numpy as np

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.mapping.surfel_grid import INFORMATION, NX, NY, X, Y
from slam.pose import FloatArray

W, WX, WY, WXX, WXY, WYY = range(6)
"""The weighted sums from which a line is fitted: of 1, x, y, xx, xy and yy."""
NEIGHBOURS = 2  # cells to each side in which a wall may go on
MAX_GAP = 2.2  # cells: surfels of one wall are no farther apart than this along it
MAX_OFFSET = 0.03  # metres by which a surfel may lie off the wall that it joins
WALL_COSINE = 0.9  # between its normal and the wall's, at least
SIGMA_FLOOR = 0.01  # metres: no surfel is surer than this, one standard deviation
MIN_SURFELS = 2  # of a wall


def wall_segments(surfels: FloatArray, cell: float) -> FloatArray:
    """Start and end of the walls that these surfels (S, 7) with a normal make, shape (M, 2, 2): [wall, start or end, x
    or y]; metres, map frame. Walls are grown in the order of their surest surfel."""
    surest_first = np.ascontiguousarray(surfels[np.argsort(-surfels[:, INFORMATION], kind="stable")])
    columns_rows = np.floor(surest_first[:, :2] / cell).astype(np.int64)
    columns_rows += NEIGHBOURS + 1 - columns_rows.min(axis=0, initial=0)
    columns, rows = columns_rows.max(axis=0, initial=0) + NEIGHBOURS + 2
    wall_of = _wall_numbers(surest_first, columns_rows, np.full((rows, columns), -1, np.int64), cell)
    by_wall = np.argsort(wall_of, kind="stable")
    begins = np.searchsorted(wall_of[by_wall], np.arange(wall_of.max(initial=-1) + 2))
    kept = np.flatnonzero(np.diff(begins) >= MIN_SURFELS)
    ends = np.empty((len(kept), 2, 2))
    for m, wall in enumerate(kept):
        _fit(surest_first[by_wall[begins[wall] : begins[wall + 1]]], ends[m])
    return ends


@compiled
def _wall_numbers(surfels: FloatArray, columns_rows: IntArray, head: IntArray, cell: float) -> IntArray:
    """Number the wall of each surfel, (S,); ``head`` has a -1 for every cell, and becomes the first surfel of each."""
    following, wall_of = np.empty(len(surfels), np.int64), np.full(len(surfels), -1, np.int64)
    for k in range(len(surfels)):
        column, row = columns_rows[k]
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
    """One wall, from its surest surfel outwards over its neighbours; ``queue`` (S,) is scratch."""
    sums = np.zeros(6)
    _include(sums, surfels[seed], surfels[seed, X], surfels[seed, Y])
    wall_of[seed], queue[0] = number, seed
    begin, end = 0, 1
    while begin < end:
        at = queue[begin]
        begin += 1
        column, row = columns_rows[at]
        for i in range(row - NEIGHBOURS, row + NEIGHBOURS + 1):
            for j in range(column - NEIGHBOURS, column + NEIGHBOURS + 1):
                k = head[i, j]
                while k >= 0:
                    if wall_of[k] < 0 and _continues(sums, surfels[seed], surfels[at], surfels[k], cell):
                        wall_of[k], queue[end] = number, k
                        end += 1
                        _include(sums, surfels[k], surfels[seed, X], surfels[seed, Y])
                    k = following[k]


@compiled
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


@compiled
def _line(sums: FloatArray, nx: float, ny: float) -> tuple[float, float, float, float]:
    """Normal and mean of the best line, the normal to the side of (nx, ny), which it is where there is one point."""
    mx, my = sums[WX] / sums[W], sums[WY] / sums[W]
    xx, xy, yy = sums[WXX] - mx * sums[WX], sums[WXY] - mx * sums[WY], sums[WYY] - my * sums[WY]
    if xx + yy < 1e-3 * sums[W]:  # shorter than it is sure
        return nx, ny, mx, my
    half = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    lx, ly = -np.sin(half), np.cos(half)
    side = 1.0 if lx * nx + ly * ny >= 0.0 else -1.0
    return side * lx, side * ly, mx, my


@compiled
def _continues(sums: FloatArray, seed: FloatArray, at: FloatArray, s: FloatArray, cell: float) -> bool:
    """True where the surfel ``s`` continues the wall at its surfel ``at``."""
    nx, ny, mx, my = _line(sums, seed[NX], seed[NY])
    if s[NX] * nx + s[NY] * ny < WALL_COSINE:
        return False
    if abs((s[X] - seed[X] - mx) * nx + (s[Y] - seed[Y] - my) * ny) > MAX_OFFSET:
        return False
    dx, dy = s[X] - at[X], s[Y] - at[Y]
    return bool(dx * dx + dy * dy < (MAX_GAP * cell) ** 2)


@compiled
def _fit(members: FloatArray, ends: FloatArray) -> None:
    """Fill the ends (2, 2) of the surfels (K, 7) of one wall, on their best line."""
    sums = np.zeros(6)
    x0, y0 = members[0, X], members[0, Y]
    for k in range(len(members)):
        _include(sums, members[k], x0, y0)
    nx, ny, mx, my = _line(sums, members[0, NX], members[0, NY])
    low, high = np.inf, -np.inf
    for k in range(len(members)):
        t = (members[k, Y] - y0 - my) * nx - (members[k, X] - x0 - mx) * ny
        low, high = min(low, t), max(high, t)
    x, y = x0 + mx, y0 + my
    ends[0, 0], ends[0, 1], ends[1, 0], ends[1, 1] = x - low * ny, y + low * nx, x - high * ny, y + high * nx
