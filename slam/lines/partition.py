"""A partition of the points of a scan into runs, and the steps that improve it towards one run per wall; compiled.

Each step takes the sums of beam_sums.py and the ``m`` runs of a partition, and returns the new number of runs.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.lines.beam_sums import chi_square
from slam.lines.segments import IntArray
from slam.pose import FloatArray

BLOCK = 8  # points of the largest initial runs
GOOD_FIT = 0.85  # chi-square per point below which a block becomes one initial run
SMALL_RUN = 12  # points: a run this small between two others may be only their corner
WINDOW = 8  # points to both sides in which the end of a run is searched


class Partition(NamedTuple):
    """Points of a scan, cut into runs; the arrays have room for more runs."""

    start: IntArray
    """First point of each run; then, after the last one, the number of points."""
    after_gap: NDArray[np.bool_]
    """True for a run separated by a gap from the previous one, and after the last one."""
    cost: FloatArray
    """Chi-square of each run about its best line."""


@compiled_on_views
def cut_blocks(sums: FloatArray, new: NDArray[np.bool_], n: int, partition: Partition) -> int:
    """Cut the ``n`` points into runs of eight or four if these lie well on a line, else of two; an odd rest has three.

    ``new`` is True for each point after a gap, where a run must begin.
    """
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
def merge(sums: FloatArray, m: int, partition: Partition, limit: float) -> int:
    """Merge neighbouring runs while a merge adds less than ``limit`` to chi-square.

    Each pass merges the pairs that add less than the pairs on both sides.
    """
    start, after_gap, cost = partition
    rise = np.full(m + 1, np.inf)  # chi-square added by merging a run with the next
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
def reduced_chi_square(m: int, partition: Partition) -> float:
    """Return chi-square of all runs over its expectation."""
    start, _, cost = partition
    total = expected = 0.0
    for k in range(m):
        if start[k + 1] - start[k] > 2:
            total += cost[k]
            expected += start[k + 1] - start[k] - 2
    return total / max(expected, 1.0)


@compiled_on_views
def _cheapest_cut(sums: FloatArray, begin: int, stop: int, low: int, high: int) -> tuple[float, int]:
    """Cut points into two runs of least chi-square, between ``low`` and ``high``; return that sum, and the cut."""
    least, at = np.inf, low
    for i in range(max(low, begin + 2), min(high, stop - 2) + 1):
        both = chi_square(sums, begin, i) + chi_square(sums, i, stop)
        if both < least:
            least, at = both, i
    return least, at


@compiled_on_views
def drop_small(sums: FloatArray, m: int, partition: Partition, limit: float) -> int:
    """Split a small run between its two neighbours if that costs less than the limit."""
    start, after_gap, cost = partition
    out = 0
    for k in range(m):
        start[out], after_gap[out], cost[out] = start[k], after_gap[k], cost[k]
        if out > 0 and not after_gap[k] and not after_gap[k + 1] and start[k + 1] - start[k] <= SMALL_RUN:
            begin, stop = start[out - 1], start[k + 2]
            both, at = _cheapest_cut(sums, begin, stop, start[k], start[k + 1])
            if both - cost[out - 1] - cost[k] - cost[k + 1] < limit:
                start[k + 1] = at
                cost[out - 1], cost[k + 1] = chi_square(sums, begin, at), chi_square(sums, at, stop)
                continue
        out += 1
    start[out], after_gap[out] = start[m], True
    return out


@compiled_on_views
def move_cuts(sums: FloatArray, m: int, partition: Partition) -> None:
    """Move the boundary of every two neighbours to where it costs least."""
    start, after_gap, cost = partition
    for k in range(1, m):
        if not after_gap[k]:
            _, start[k] = _cheapest_cut(sums, start[k - 1], start[k + 1], start[k] - WINDOW, start[k] + WINDOW)
    for k in range(m):
        cost[k] = chi_square(sums, start[k], start[k + 1]) if start[k + 1] - start[k] > 2 else 0.0


@compiled_on_views
def merge_three(sums: FloatArray, m: int, partition: Partition, limit: float) -> int:
    """Merge three neighbouring runs into one if that costs less than the limit."""
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
