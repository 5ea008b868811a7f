"""Runs of beams that saw one straight wall each, merged from the bottom up by chi-square; compiled."""

import numpy as np

from slam.compiled import compiled
from slam.lines.beam_sums import SUMS, prefix_sums
from slam.lines.partition import Partition, cut_blocks, drop_small, merge, merge_three, move_cuts, reduced_chi_square
from slam.lines.range_noise import RangeNoise
from slam.lines.segments import IntArray
from slam.pose import FloatArray

FIRST_POINT, LAST_POINT, FIRST_BEAM, LAST_BEAM, MEETS_NEXT = range(5)
"""Columns of runs (M, 5): points are the beams with an echo; MEETS_NEXT is 1 if the next point is the first of the next
run, else 0."""
THREE_RUNS = 1.5  # limit for merging three runs over that for two: four parameters less, not two


@compiled
def wall_runs(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: RangeNoise, merge_cost: float,
    min_points: int,
) -> tuple[IntArray, FloatArray]:  # fmt: skip
    """Find the runs (M, 5) of the beams of one scan, and the six sums of each, shape (M, 6).

    ``fan`` (3, N) has the bearings in order; ``reach`` is the least and greatest range of an echo.
    """
    N = len(ranges)
    sums, beam, after_gap = np.empty((N + 1, SUMS)), np.empty(N, np.int64), np.empty(N + 1, np.bool_)
    n = prefix_sums(ranges, fan, reach, noise, sums, beam, after_gap)
    partition = Partition(np.empty(n + 1, np.int64), np.empty(n + 1, np.bool_), np.empty(n + 1))
    m = cut_blocks(sums, after_gap, n, partition)
    m = merge(sums, m, partition, merge_cost)
    scale = reduced_chi_square(m, partition)
    if scale > 1.0:  # the ranges are noisier than assumed
        merge_cost *= scale
        m = merge(sums, m, partition, merge_cost)
    m = drop_small(sums, m, partition, merge_cost)
    move_cuts(sums, m, partition)
    m = merge(sums, m, partition, merge_cost)
    m = merge_three(sums, m, partition, THREE_RUNS * merge_cost)
    return _kept(sums, m, partition, beam, min_points)


@compiled
def wall_runs_of_scans(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: RangeNoise, merge_cost: float,
    min_points: int,
) -> tuple[IntArray, FloatArray, IntArray]:  # fmt: skip
    """Find the runs in scans (B, N) of one sensor: runs (B, most, 5), sums (B, most, 6), their number (B,)."""
    scans, most = len(ranges), ranges.shape[1] // min_points + 1
    runs, totals = np.empty((scans, most, 5), np.int64), np.empty((scans, most, SUMS))
    counts = np.empty(scans, np.int64)
    for i in range(scans):
        found, sums = wall_runs(ranges[i], fan, reach, noise, merge_cost, min_points)
        counts[i] = len(found)
        runs[i, : len(found)], totals[i, : len(found)] = found, sums
    return runs, totals, counts


@compiled
def _kept(
    sums: FloatArray, m: int, partition: Partition, beam: IntArray, min_points: int
) -> tuple[IntArray, FloatArray]:
    """Return the runs with enough points, and their sums."""
    start, after_gap, _ = partition
    runs, totals = np.empty((m, 5), np.int64), np.empty((m, SUMS))
    M = 0
    for k in range(m):
        first, last = start[k], start[k + 1] - 1
        if last - first + 1 >= min_points:
            run = runs[M]
            run[FIRST_POINT], run[LAST_POINT], run[FIRST_BEAM], run[LAST_BEAM] = first, last, beam[first], beam[last]
            run[MEETS_NEXT] = not after_gap[k + 1] and start[k + 2] - start[k + 1] >= min_points
            for i in range(SUMS):
                totals[M, i] = sums[last + 1, i] - sums[first, i]
            M += 1
    return runs[:M], totals[:M]
