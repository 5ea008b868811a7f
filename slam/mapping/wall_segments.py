"""The walls of the map: surfels that lie on one line and touch are one segment, with its covariance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.pose import FloatArray

SUMS = 6
REACH = 2.2  # cells: surfels of one wall are no farther apart than this along it
OFF_LINE = 0.03  # metres by which a surfel may lie off the wall that it joins
SAME_WAY = 0.9  # cosine between its normal and the wall's
FLOOR = 0.01  # metres: walls are no better than this, one standard deviation of a surfel
LEAST = 2  # surfels of a wall


class Walls(NamedTuple):
    """M walls of the map, in the map frame."""

    ends: FloatArray
    """(M, 2, 2): [wall, start or end, x or y], metres."""
    line: FloatArray
    """(M, 2): rho and theta of ``x cos(theta) + y sin(theta) = rho``; the normal points away from where it was seen, so
    rho may be negative."""
    covariance: FloatArray
    """(M, 2, 2) of [distance at the middle, theta]: metres and radians."""
    surfels: IntArray
    """(M,): how many there are in each."""


def wall_segments(surfels: FloatArray, cell: float) -> Walls:
    """The walls that these surfels (S, 7) with a normal make, the longest grown first from the surest surfel."""
    order = np.argsort(-surfels[:, 4], kind="stable")
    ordered = np.ascontiguousarray(surfels[order])
    columns = np.floor(ordered[:, :2] / cell).astype(np.int64)
    corner = columns.min(axis=0, initial=0) - 3
    shape = columns.max(axis=0, initial=0) - corner + 4
    head, following = np.full((shape[1], shape[0]), -1, np.int64), np.full(len(ordered), -1, np.int64)
    of = np.full(len(ordered), -1, np.int64)
    count = _grow(ordered, columns - corner, head, following, cell, of)
    return _fitted(ordered, of, count)


@compiled
def _grow(surfels: FloatArray, place: IntArray, head: IntArray, following: IntArray, cell: float, of: IntArray) -> int:
    """Number the walls: from each surfel not yet taken, outwards over its neighbours; fills ``of`` (S,)."""
    for k in range(len(surfels)):
        following[k] = head[place[k, 1], place[k, 0]]
        head[place[k, 1], place[k, 0]] = k
    queue = np.empty(len(surfels), np.int64)
    count = 0
    for seed in range(len(surfels)):
        if of[seed] >= 0:
            continue
        sums = np.zeros(SUMS)
        _include(sums, surfels[seed], surfels[seed, 0], surfels[seed, 1])
        of[seed], queue[0] = count, seed
        begin, end = 0, 1
        while begin < end:
            at = queue[begin]
            begin += 1
            for row in range(place[at, 1] - 2, place[at, 1] + 3):
                for column in range(place[at, 0] - 2, place[at, 0] + 3):
                    k = head[row, column]
                    while k >= 0:
                        if of[k] < 0 and _fits(sums, surfels[seed], surfels[at], surfels[k], cell):
                            of[k], queue[end] = count, k
                            end += 1
                            _include(sums, surfels[k], surfels[seed, 0], surfels[seed, 1])
                        k = following[k]
        count += 1
    return count


@compiled
def _include(sums: FloatArray, s: FloatArray, x0: float, y0: float) -> None:
    """Weighted sums of 1, x, y, xx, xy, yy about (x0, y0)."""
    w = 1.0 / (1.0 / s[4] + FLOOR * FLOOR)
    x, y = s[0] - x0, s[1] - y0
    sums[0] += w
    sums[1] += w * x
    sums[2] += w * y
    sums[3] += w * x * x
    sums[4] += w * x * y
    sums[5] += w * y * y


@compiled
def _line(sums: FloatArray, nx: float, ny: float) -> tuple[float, float, float, float]:
    """Normal and mean of the best line, the normal to the side of (nx, ny), which it is where there is one point."""
    mx, my = sums[1] / sums[0], sums[2] / sums[0]
    xx, xy, yy = sums[3] - mx * sums[1], sums[4] - mx * sums[2], sums[5] - my * sums[2]
    if xx + yy < 1e-3 * sums[0]:  # shorter than it is sure
        return nx, ny, mx, my
    half = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    lx, ly = -np.sin(half), np.cos(half)
    side = 1.0 if lx * nx + ly * ny >= 0.0 else -1.0
    return side * lx, side * ly, mx, my


@compiled
def _fits(sums: FloatArray, seed: FloatArray, at: FloatArray, s: FloatArray, cell: float) -> bool:
    """Whether the surfel ``s`` continues the wall at its surfel ``at``."""
    nx, ny, mx, my = _line(sums, seed[2], seed[3])
    if s[2] * nx + s[3] * ny < SAME_WAY:
        return False
    if abs((s[0] - seed[0] - mx) * nx + (s[1] - seed[1] - my) * ny) > OFF_LINE:
        return False
    dx, dy = s[0] - at[0], s[1] - at[1]
    return bool(dx * dx + dy * dy < (REACH * cell) ** 2)


@compiled
def _fit_one(members: FloatArray, ends: FloatArray, line: FloatArray, covariance: FloatArray) -> None:
    """Line, ends and covariance of the surfels (K, 7) of one wall."""
    sums = np.zeros(SUMS)
    x0, y0 = members[0, 0], members[0, 1]
    for k in range(len(members)):
        _include(sums, members[k], x0, y0)
    nx, ny, mx, my = _line(sums, members[0, 2], members[0, 3])
    low, high, spread = np.inf, -np.inf, 0.0
    for k in range(len(members)):
        t = (members[k, 1] - y0 - my) * nx - (members[k, 0] - x0 - mx) * ny
        low, high = min(low, t), max(high, t)
        spread += t * t / (1.0 / members[k, 4] + FLOOR * FLOOR)
    x, y = x0 + mx, y0 + my
    ends[0, 0], ends[0, 1], ends[1, 0], ends[1, 1] = x - low * ny, y + low * nx, x - high * ny, y + high * nx
    line[0], line[1] = x * nx + y * ny, np.arctan2(ny, nx)
    covariance[0, 0], covariance[1, 1] = 1.0 / sums[0], 1.0 / max(spread, 1e-9)
    covariance[0, 1] = covariance[1, 0] = 0.0  # about the middle, the two are independent


def _fitted(surfels: FloatArray, of: IntArray, count: int) -> Walls:
    """The walls of at least LEAST surfels."""
    by_wall = np.argsort(of, kind="stable")
    begins = np.searchsorted(of[by_wall], np.arange(count + 1))
    kept = np.flatnonzero(np.diff(begins) >= LEAST)
    walls = Walls(
        np.empty((len(kept), 2, 2)), np.empty((len(kept), 2)), np.empty((len(kept), 2, 2)), np.diff(begins)[kept]
    )
    for m, wall in enumerate(kept):
        members = surfels[by_wall[begins[wall] : begins[wall + 1]]]
        _fit_one(members, walls.ends[m], walls.line[m], walls.covariance[m])
    return walls
