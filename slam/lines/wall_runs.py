"""Which runs of beams saw one straight wall each: bottom-up, by chi-square in inverse range, compiled.

On the line a x + b y = 1 a beam of bearing t has 1/r = a cos(t) + b sin(t), which is linear in (a, b) whatever the
incidence. With range noise sigma_r the chi-square of a run is the least sum of q (1 - a x - b y)^2, where
q = r^2 / sigma_r^2, and six prefix sums of q give it for any run: q, q x, q y, q x^2, q x y, q y^2.

All of it stands in one file because compiled functions call none of another file (see slam/compiled.py).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.lines.range_noise import range_variance
from slam.lines.segments import IntArray
from slam.pose import FloatArray

GAP = 0.05  # metres; a jump longer than this, and than six beam spacings and three sigmas together, parts two walls
GAP_SPACINGS = 6.0
GAP_SIGMAS = 3.0
SMALL = 12  # beams: a run this small between two others may be only the corner where they meet
BLOCK = 8  # points
QUIET = 0.85  # times its points: a block of them whose chi-square is below this is begun with as it is
WINDOW = 8  # beams to both sides in which the end of a run is sought
THREE = 1.5  # the cost allowed for making one run of three is this times that for two: four parameters go, not two
SUMS = 6


@compiled
def wall_runs(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: tuple[float, float, float, float],
    merge_cost: float, min_points: int,
) -> tuple[IntArray, FloatArray]:  # fmt: skip
    """Runs (M, 5) of the beams of one scan, and the six sums of each, shape (M, 6).

    ``fan`` (3, N) has the bearings in order, their cosines and sines; ``reach`` the least and greatest range that is an
    echo; ``noise`` is as in RangeNoise. A run is [first point, last point, first beam, last beam, whether the next
    point is the first of the next run], where points are the beams with an echo.
    """
    most = len(ranges) // min_points + 1
    runs, totals = np.empty((most, 5), np.int64), np.empty((most, SUMS))
    M = _find(ranges, fan, reach, noise, merge_cost, min_points, runs, totals)
    return runs[:M], totals[:M]


@compiled
def wall_runs_of_many(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: tuple[float, float, float, float],
    merge_cost: float, min_points: int,
) -> tuple[IntArray, FloatArray, IntArray]:  # fmt: skip
    """The same for scans (B, N) of one sensor: runs (B, most, 5), sums (B, most, 6), how many (B,)."""
    scans, beams = ranges.shape
    most = beams // min_points + 1
    runs, totals = np.empty((scans, most, 5), np.int64), np.empty((scans, most, SUMS))
    counts = np.empty(scans, np.int64)
    for i in range(scans):
        counts[i] = _find(ranges[i], fan, reach, noise, merge_cost, min_points, runs[i], totals[i])
    return runs, totals, counts


@compiled
def _find(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: tuple[float, float, float, float],
    merge_cost: float, min_points: int, runs: IntArray, totals: FloatArray,
) -> int:  # fmt: skip
    N = len(ranges)
    sums, beam, new = np.empty((N + 1, SUMS)), np.empty(N, np.int64), np.empty(N + 1, np.bool_)
    n = prefix_sums(ranges, fan, reach, noise, sums, beam, new)
    cut, parted, cost, edge = np.empty(n + 1, np.int64), np.empty(n + 1, np.bool_), np.empty(n + 1), np.empty(n + 1)
    m = _blocks(sums, new, n, cut, parted, cost)
    m = _merge(sums, m, cut, parted, cost, edge, merge_cost)
    scale = _misfit(m, cut, cost)
    if scale > 1.0:  # the ranges are noisier than they were said to be
        merge_cost *= scale
        m = _merge(sums, m, cut, parted, cost, edge, merge_cost)
    m = _drop_small(sums, m, cut, parted, cost, merge_cost)
    _move_cuts(sums, m, cut, parted, cost)
    m = _merge(sums, m, cut, parted, cost, edge, merge_cost)
    m = _merge_three(sums, m, cut, parted, cost, THREE * merge_cost)
    return _keep(sums, m, cut, parted, beam, min_points, runs, totals)


@compiled
def prefix_sums(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: tuple[float, float, float, float],
    sums: FloatArray, beam: IntArray, new: NDArray[np.bool_],
) -> int:  # fmt: skip
    """Fill the sums before each point, the beam of each, and whether a gap parts it from the last; returns how many."""
    n = 0
    q = qx = qy = qxx = qxy = qyy = 0.0
    last_x = last_y = last_bearing = last_r = 0.0
    sums[0] = 0.0
    for j in range(len(ranges)):
        r = ranges[j]
        if not (reach[0] <= r <= reach[1]):
            continue
        variance = range_variance(r, noise)
        x, y, w = r * fan[1, j], r * fan[2, j], r * r / variance
        q, qx, qy = q + w, qx + w * x, qy + w * y
        qxx, qxy, qyy = qxx + w * x * x, qxy + w * x * y, qyy + w * y * y
        spacing = min(r, last_r) * abs(fan[0, j] - last_bearing)
        gap = GAP + GAP_SPACINGS * spacing + GAP_SIGMAS * np.sqrt(2.0 * variance)
        new[n] = (x - last_x) ** 2 + (y - last_y) ** 2 > gap * gap
        last_x, last_y, last_r, last_bearing = x, y, r, fan[0, j]
        beam[n] = j
        n += 1
        sums[n, 0], sums[n, 1], sums[n, 2] = q, qx, qy
        sums[n, 3], sums[n, 4], sums[n, 5] = qxx, qxy, qyy
    new[0] = new[n] = True
    return n


@compiled
def chi_square(sums: FloatArray, i: int, j: int) -> float:
    """Of the points i to j (exclusive) about their best line; infinite where they lie in one bearing."""
    q, x, y = sums[j, 0] - sums[i, 0], sums[j, 1] - sums[i, 1], sums[j, 2] - sums[i, 2]
    xx, xy, yy = sums[j, 3] - sums[i, 3], sums[j, 4] - sums[i, 4], sums[j, 5] - sums[i, 5]
    determinant = xx * yy - xy * xy
    if determinant <= 1e-12 * xx * yy:
        return np.inf
    return float(q - (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant)


@compiled
def _blocks(
    sums: FloatArray, new: NDArray[np.bool_], n: int, cut: IntArray, parted: NDArray[np.bool_], cost: FloatArray
) -> int:
    """Begin with runs of eight or four points where these lie well on a line, else of two, or of three at the end of an
    odd piece: where each begins, whether a gap precedes it, and its chi-square."""
    m = begin = 0
    for stop in range(1, n + 1):
        if not new[stop]:
            continue
        i = begin
        while i < stop:
            size = min(stop - i, BLOCK)
            while size > 3:
                cost[m] = chi_square(sums, i, i + size)
                if cost[m] < QUIET * size:
                    break
                size //= 2
            if size <= 3:
                size = 3 if stop - i == 3 else min(stop - i, 2)
                cost[m] = chi_square(sums, i, i + 3) if size == 3 else 0.0
            cut[m], parted[m] = i, i == begin
            i += size
            m += 1
        begin = stop
    cut[m], parted[m] = n, True
    return m


@compiled
def _merge(
    sums: FloatArray, m: int, cut: IntArray, parted: NDArray[np.bool_], cost: FloatArray, edge: FloatArray, limit: float
) -> int:
    """Make one run of two neighbours, cheapest first around each, while that costs less than the limit."""
    changed = np.ones(m + 1, np.bool_)
    for k in range(m):
        edge[k] = np.inf
    merged = True
    while merged:
        for k in range(m - 1):
            if (changed[k] or changed[k + 1]) and not parted[k + 1]:
                edge[k] = chi_square(sums, cut[k], cut[k + 2]) - cost[k] - cost[k + 1]
        merged = False
        out = k = 0
        before = np.inf
        while k < m:
            here = edge[k]
            cut[out], parted[out], cost[out], changed[out] = cut[k], parted[k], cost[k], False
            if here < limit and here <= before and here < edge[k + 1]:
                cost[out] += here + cost[k + 1]
                changed[out] = merged = True
                k += 1
            before = edge[out] = edge[k]
            k += 1
            out += 1
        cut[out], parted[out], edge[out], changed[out] = cut[m], True, np.inf, False
        m = out
    return m


@compiled
def _misfit(m: int, cut: IntArray, cost: FloatArray) -> float:
    """Chi-square of all runs over its expectation."""
    total = expected = 0.0
    for k in range(m):
        if cut[k + 1] - cut[k] > 2:
            total += cost[k]
            expected += cut[k + 1] - cut[k] - 2
    return total / max(expected, 1.0)


@compiled
def _cheapest_cut(sums: FloatArray, begin: int, stop: int, low: int, high: int) -> tuple[float, int]:
    """Where, from ``low`` to ``high``, to part the points ``begin`` to ``stop`` in two; with their chi-square."""
    least, at = np.inf, low
    for i in range(max(low, begin + 2), min(high, stop - 2) + 1):
        both = chi_square(sums, begin, i) + chi_square(sums, i, stop)
        if both < least:
            least, at = both, i
    return least, at


@compiled
def _drop_small(
    sums: FloatArray, m: int, cut: IntArray, parted: NDArray[np.bool_], cost: FloatArray, limit: float
) -> int:
    """Share out a small run among its two neighbours where that costs less than the limit."""
    out = 0
    for k in range(m):
        cut[out], parted[out], cost[out] = cut[k], parted[k], cost[k]
        if out > 0 and not parted[k] and not parted[k + 1] and cut[k + 1] - cut[k] <= SMALL:
            begin, stop = cut[out - 1], cut[k + 2]
            both, at = _cheapest_cut(sums, begin, stop, cut[k], cut[k + 1])
            if both - cost[out - 1] - cost[k] - cost[k + 1] < limit:
                cut[k + 1] = at
                cost[out - 1], cost[k + 1] = chi_square(sums, begin, at), chi_square(sums, at, stop)
                continue
        out += 1
    cut[out], parted[out] = cut[m], True
    return out


@compiled
def _move_cuts(sums: FloatArray, m: int, cut: IntArray, parted: NDArray[np.bool_], cost: FloatArray) -> None:
    """Let every two neighbours meet where that is cheapest."""
    for k in range(1, m):
        if not parted[k]:
            _, cut[k] = _cheapest_cut(sums, cut[k - 1], cut[k + 1], cut[k] - WINDOW, cut[k] + WINDOW)
    for k in range(m):
        cost[k] = chi_square(sums, cut[k], cut[k + 1]) if cut[k + 1] - cut[k] > 2 else 0.0


@compiled
def _merge_three(
    sums: FloatArray, m: int, cut: IntArray, parted: NDArray[np.bool_], cost: FloatArray, limit: float
) -> int:
    """Make one run of three neighbours where that costs less than the limit."""
    out = k = 0
    while k < m:
        cut[out], parted[out], cost[out] = cut[k], parted[k], cost[k]
        if k + 2 < m and not parted[k + 1] and not parted[k + 2]:
            whole = chi_square(sums, cut[k], cut[k + 3])
            if whole - cost[k] - cost[k + 1] - cost[k + 2] < limit:
                cost[out] = whole
                k += 2
        k += 1
        out += 1
    cut[out], parted[out] = cut[m], True
    return out


@compiled
def _keep(
    sums: FloatArray, m: int, cut: IntArray, parted: NDArray[np.bool_], beam: IntArray, min_points: int, runs: IntArray,
    totals: FloatArray,
) -> int:  # fmt: skip
    """Write the runs of enough points; returns how many."""
    M = 0
    for k in range(m):
        first, last = cut[k], cut[k + 1] - 1
        if last - first + 1 >= min_points:
            followed = not parted[k + 1] and cut[k + 2] - cut[k + 1] >= min_points
            runs[M, 0], runs[M, 1], runs[M, 2], runs[M, 3], runs[M, 4] = first, last, beam[first], beam[last], followed
            for s in range(SUMS):
                totals[M, s] = sums[last + 1, s] - sums[first, s]
            M += 1
    return M
