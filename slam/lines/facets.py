"""Facets, the items that are matched: short pieces of wall with a normal, and small clusters of points without one."""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.lines.learnt_noise import LearntNoise
from slam.lines.range_noise import RangeNoise, range_variance
from slam.lines.segments import IntArray, Segments
from slam.pose import FloatArray
from slam.scan import COS, SIN, LaserScan

X, Y, NX, NY, VARIANCE, COUNT, LINKED = range(7)
"""Columns of facets (F, 7): centre, unit normal away from the sensor (0, 0 for a cluster), variance of the centre along
the normal (m^2), number of points, and 1 if the previous facet is of the same segment, else 0."""
RANGE_FLOOR = 0.003  # metres: least standard deviation of a range; the matcher adds that of walls that are not flat
CLUSTER_GAP = 0.10  # metres, the largest gap between neighbouring points of a cluster
CLUSTER_SIZE = 0.15  # metres, the largest size of a cluster
TRUNCATED_SIGMAS = 2.5  # standard deviations before the range limit from which the longer readings are missing


def facets_of(scan: LaserScan, segments: Segments, length: float) -> FloatArray:
    """Cut segments, and the points beside them, into facets (F, 7) of at most ``length`` metres, sensor frame."""
    fan, reach = scan.fan, scan.reach
    noise = (segments.noise or LearntNoise.start().observe(scan))._replace(floor=RANGE_FLOOR)
    return _facets(scan.ranges, fan, reach, segments.first, segments.last, segments.theta, noise, length)


@compiled
def _facets(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], first: IntArray, last: IntArray,
    theta: FloatArray, noise: RangeNoise, length: float,
) -> FloatArray:  # fmt: skip
    points, n = np.empty((len(ranges), 2)), 0
    for j in range(len(ranges)):
        if reach[0] <= ranges[j] <= reach[1]:
            points[n, 0], points[n, 1] = ranges[j] * fan[COS, j], ranges[j] * fan[SIN, j]
            n += 1
    facets = np.zeros((n + 1, 7))
    count = begin = 0
    for m in range(len(first)):
        count = _clusters(points, begin, first[m], noise, facets, count)
        count = _cut(points, first[m], last[m] + 1, theta[m], noise, length, facets, count)
        begin = max(begin, last[m] + 1)
    count = _clusters(points, begin, n, noise, facets, count)
    return facets[: _drop_truncated(facets, count, reach[1], noise)]


@compiled
def _drop_truncated(facets: FloatArray, count: int, range_max: float, noise: RangeNoise) -> int:
    """Leave out facets so near the range limit that about half of their echoes were lost beyond it.

    The remaining readings are too short: a far wall would be mapped too near.
    """
    kept, unbroken = 0, True
    for k in range(count):
        r = np.hypot(facets[k, X], facets[k, Y])
        if r + TRUNCATED_SIGMAS * np.sqrt(range_variance(r, noise)) > range_max:
            unbroken = False
            continue
        if kept != k:
            facets[kept] = facets[k]
        if not unbroken:
            facets[kept, LINKED] = 0.0
        kept, unbroken = kept + 1, True
    return kept


@compiled_on_views
def _cut(
    points: FloatArray, begin: int, stop: int, theta: float, noise: RangeNoise, length: float,
    facets: FloatArray, count: int,
) -> int:  # fmt: skip
    """Cut one segment into pieces no longer than ``length``, and write a facet for each."""
    nx, ny = np.cos(theta), np.sin(theta)
    s0 = nx * points[begin, 1] - ny * points[begin, 0]
    whole = nx * points[stop - 1, 1] - ny * points[stop - 1, 0] - s0
    pieces = max(1, int(np.ceil(abs(whole) / length)))
    at, start = -1, count
    for i in range(begin, stop):
        x, y = points[i, 0], points[i, 1]
        piece = min(max(int((nx * y - ny * x - s0) / whole * pieces), 0), pieces - 1) if whole != 0.0 else 0
        if piece != at:
            at = piece
            facets[count] = 0.0
            facets[count, NX], facets[count, NY] = nx, ny
            facets[count, LINKED] = 1.0 if count > start else 0.0
            count += 1
        r2 = x * x + y * y
        facet = facets[count - 1]
        facet[X] += x
        facet[Y] += y
        facet[VARIANCE] += range_variance(np.sqrt(r2), noise) * (nx * x + ny * y) ** 2 / max(r2, 1e-12)
        facet[COUNT] += 1.0
    for k in range(start, count):
        n = facets[k, COUNT]
        facets[k, X], facets[k, Y] = facets[k, X] / n, facets[k, Y] / n
        facets[k, VARIANCE] /= n * n
    return count


@compiled_on_views
def _clusters(points: FloatArray, begin: int, stop: int, noise: RangeNoise, facets: FloatArray, count: int) -> int:
    """Write a facet without normal for each group of at least two neighbouring points off the segments."""
    i = begin
    while i < stop:
        j, x, y, v = i, 0.0, 0.0, 0.0
        while j < stop:
            px, py = points[j, 0], points[j, 1]
            if j > i and np.hypot(px - points[j - 1, 0], py - points[j - 1, 1]) > CLUSTER_GAP:
                break
            if np.hypot(px - points[i, 0], py - points[i, 1]) > CLUSTER_SIZE:
                break
            x, y, v = x + px, y + py, v + range_variance(np.hypot(px, py), noise)
            j += 1
        n = j - i
        if n >= 2:
            facets[count] = 0.0
            facets[count, X], facets[count, Y] = x / n, y / n
            facets[count, VARIANCE], facets[count, COUNT] = v / (n * n), n
            count += 1
        i = j
    return count
