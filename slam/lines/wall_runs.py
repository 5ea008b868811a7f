"""Runs of beams that saw one straight wall each, merged from the bottom up by chi-square (beam_sums.py); compiled.

Where two walls meet is moved to where it costs least, and small runs between two others are shared out among them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.lines.beam_sums import SUMS, chi_square, prefix_sums
from slam.lines.range_noise import RangeNoise
from slam.lines.segments import IntArray
from slam.pose import FloatArray

FIRST_POINT, LAST_POINT, FIRST_BEAM, LAST_BEAM, MEETS_NEXT = range(5)
"""Columns of the runs (M, 5) that are found: points are the beams with an echo; MEETS_NEXT is 1 where the next point is
the first of the next run, else 0."""
BLOCK = 8  # points of the largest runs to begin with
GOOD_FIT = 0.85  # of its points: a block whose chi-square is below this is begun with as it is
SMALL = 12  # points: a run this small between two others may be only the corner where they meet
WINDOW = 8  # points to both sides in which the end of a run is sought
THREE = 1.5  # the cost allowed for making one run of three is this times that for two: four parameters go, not two


class Partition(NamedTuple):
    """The points of a scan, cut into runs; there is room for more runs than there are."""

    start: IntArray
    """First point of each run; then, behind the last one, the number of points."""
    after_gap: NDArray[np.bool_]
    """Whether a gap parts the run from the one before it; True behind the last one."""
    cost: FloatArray
    """Chi-square of each run about its best line."""


@compiled
def wall_runs(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: RangeNoise, merge_cost: float,
    min_points: int,
) -> tuple[IntArray, FloatArray]:  # fmt: skip
    """Find the runs (M, 5) of the beams of one scan, and the six sums of each, shape (M, 6).

    ``fan`` (3, N) has the bearings in order, ``reach`` the least and greatest range that is an echo.
    """
    most = len(ranges) // min_points + 1
    runs, totals = np.empty((most, 5), np.int64), np.empty((most, SUMS))
    M = _find(ranges, fan, reach, noise, merge_cost, min_points, runs, totals)
    return runs[:M], totals[:M]


@compiled
def wall_runs_of_scans(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: RangeNoise, merge_cost: float,
    min_points: int,
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
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: RangeNoise, merge_cost: float,
    min_points: int, runs: IntArray, totals: FloatArray,
) -> int:  # fmt: skip
    N = len(ranges)
    sums, beam, after_gap = np.empty((N + 1, SUMS)), np.empty(N, np.int64), np.empty(N + 1, np.bool_)
    n = prefix_sums(ranges, fan, reach, noise, sums, beam, after_gap)
    partition = Partition(np.empty(n + 1, np.int64), np.empty(n + 1, np.bool_), np.empty(n + 1))
    m = _blocks(sums, after_gap, n, partition)
    m = _merge(sums, m, partition, merge_cost)
    scale = _reduced_chi_square(m, partition)
    if scale > 1.0:  # the ranges are noisier than they were said to be
        merge_cost *= scale
        m = _merge(sums, m, partition, merge_cost)
    m = _drop_small(sums, m, partition, merge_cost)
    _move_cuts(sums, m, partition)
    m = _merge(sums, m, partition, merge_cost)
    m = _merge_three(sums, m, partition, THREE * merge_cost)
    return _keep(sums, m, partition, beam, min_points, runs, totals)


@compiled
def _blocks(sums: FloatArray, new: NDArray[np.bool_], n: int, partition: Partition) -> int:
    """Begin with runs of eight or four points where these lie well on a line, else of two, or of three at the end of an
    odd piece; ``new`` says which points come after a gap. Like all that follow, return how many runs there are."""
    start, after_gap, cost = partition
    m = begin = 0
    for stop in range(1, n + 1):
        if not new[stop]:
            continue
        i = begin
        while i < stop:
            size = min(stop - i, BLOCK)
            while size > 3:
                cost[m] = chi_square(sums, i, i + size)
                if cost[m] < GOOD_FIT * size:
                    break
                size //= 2
            if size <= 3:
                size = 3 if stop - i == 3 else min(stop - i, 2)
                cost[m] = chi_square(sums, i, i + 3) if size == 3 else 0.0
            start[m], after_gap[m] = i, i == begin
            i += size
            m += 1
        begin = stop
    start[m], after_gap[m] = n, True
    return m


@compiled
def _merge(sums: FloatArray, m: int, partition: Partition, limit: float) -> int:
    """Make one run of two neighbours, cheapest first around each, while that costs less than the limit."""
    start, after_gap, cost = partition
    rise = np.full(m + 1, np.inf)  # of chi-square, by merging a run with the next
    changed = np.ones(m + 1, np.bool_)
    merged = True
    while merged:
        for k in range(m - 1):
            if (changed[k] or changed[k + 1]) and not after_gap[k + 1]:
                rise[k] = chi_square(sums, start[k], start[k + 2]) - cost[k] - cost[k + 1]
        merged = False
        out = k = 0
        before = np.inf
        while k < m:
            here = rise[k]
            start[out], after_gap[out], cost[out], changed[out] = start[k], after_gap[k], cost[k], False
            if here < limit and here <= before and here < rise[k + 1]:
                cost[out] += here + cost[k + 1]
                changed[out] = merged = True
                k += 1
            before = rise[out] = rise[k]
            k += 1
            out += 1
        start[out], after_gap[out], rise[out], changed[out] = start[m], True, np.inf, False
        m = out
    return m


@compiled
def _reduced_chi_square(m: int, partition: Partition) -> float:
    """Return chi-square of all runs over its expectation."""
    start, _, cost = partition
    total = expected = 0.0
    for k in range(m):
        if start[k + 1] - start[k] > 2:
            total += cost[k]
            expected += start[k + 1] - start[k] - 2
    return total / max(expected, 1.0)


@compiled
def _cheapest_cut(sums: FloatArray, begin: int, stop: int, low: int, high: int) -> tuple[float, int]:
    """Find where, from ``low`` to ``high``, to part the points ``begin`` to ``stop`` in two; with their chi-square."""
    least, at = np.inf, low
    for i in range(max(low, begin + 2), min(high, stop - 2) + 1):
        both = chi_square(sums, begin, i) + chi_square(sums, i, stop)
        if both < least:
            least, at = both, i
    return least, at


@compiled
def _drop_small(sums: FloatArray, m: int, partition: Partition, limit: float) -> int:
    """Share out a small run among its two neighbours where that costs less than the limit."""
    start, after_gap, cost = partition
    out = 0
    for k in range(m):
        start[out], after_gap[out], cost[out] = start[k], after_gap[k], cost[k]
        if out > 0 and not after_gap[k] and not after_gap[k + 1] and start[k + 1] - start[k] <= SMALL:
            begin, stop = start[out - 1], start[k + 2]
            both, at = _cheapest_cut(sums, begin, stop, start[k], start[k + 1])
            if both - cost[out - 1] - cost[k] - cost[k + 1] < limit:
                start[k + 1] = at
                cost[out - 1], cost[k + 1] = chi_square(sums, begin, at), chi_square(sums, at, stop)
                continue
        out += 1
    start[out], after_gap[out] = start[m], True
    return out


@compiled
def _move_cuts(sums: FloatArray, m: int, partition: Partition) -> None:
    """Let every two neighbours meet where that is cheapest."""
    start, after_gap, cost = partition
    for k in range(1, m):
        if not after_gap[k]:
            _, start[k] = _cheapest_cut(sums, start[k - 1], start[k + 1], start[k] - WINDOW, start[k] + WINDOW)
    for k in range(m):
        cost[k] = chi_square(sums, start[k], start[k + 1]) if start[k + 1] - start[k] > 2 else 0.0


@compiled
def _merge_three(sums: FloatArray, m: int, partition: Partition, limit: float) -> int:
    """Make one run of three neighbours where that costs less than the limit."""
    start, after_gap, cost = partition
    out = k = 0
    while k < m:
        start[out], after_gap[out], cost[out] = start[k], after_gap[k], cost[k]
        if k + 2 < m and not after_gap[k + 1] and not after_gap[k + 2]:
            whole = chi_square(sums, start[k], start[k + 3])
            if whole - cost[k] - cost[k + 1] - cost[k + 2] < limit:
                cost[out] = whole
                k += 2
        k += 1
        out += 1
    start[out], after_gap[out] = start[m], True
    return out


@compiled
def _keep(
    sums: FloatArray, m: int, partition: Partition, beam: IntArray, min_points: int, runs: IntArray, totals: FloatArray
) -> int:
    """Write the runs of enough points, and their sums."""
    start, after_gap, _ = partition
    M = 0
    for k in range(m):
        first, last = start[k], start[k + 1] - 1
        if last - first + 1 >= min_points:
            run = runs[M]
            run[FIRST_POINT], run[LAST_POINT], run[FIRST_BEAM], run[LAST_BEAM] = first, last, beam[first], beam[last]
            run[MEETS_NEXT] = not after_gap[k + 1] and start[k + 2] - start[k + 1] >= min_points
            for column in range(SUMS):
                totals[M, column] = sums[last + 1, column] - sums[first, column]
            M += 1
    return M
