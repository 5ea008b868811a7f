"""Split-and-merge by iterative end-point fit (Ramer 1972, Duda and Hart 1973).

It is as in the comparison of Nguyen et al., "A comparison of line extraction algorithms using 2D laser rangefinder for
indoor mobile robotics", IROS 2005.
"""

from dataclasses import dataclass

import numpy as np

from slam.compiled import compiled, wrapped
from slam.lines.segments import IntArray, Segments
from slam.pose import FloatArray, unit_vectors
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class SplitAndMerge:
    """Settings, lengths in metres; the defaults are tuned at the noise level ``spec/3`` of ``slam.bench.scenes``."""

    max_distance: float = 0.09
    """A piece is split at its farthest point if that is farther than this, metres, from the line of its ends."""
    merge_distance: float = 0.09
    """Neighbours are merged if no point is then farther than this from the common line, metres."""
    gap: float = 0.04
    """Neighbouring points farther apart than this, plus ``gap_share`` of their range, are on different walls."""
    gap_share: float = 0.06
    min_points: int = 9
    min_length: float = 0.15

    def __call__(self, scan: LaserScan) -> Segments:
        """Extract the segments of a scan, sensor frame.

        The ends of each are its first and last point, projected onto the fitted line.
        """
        points = scan.points()
        runs, lines = _split_and_merge(
            points, self.max_distance, self.merge_distance, self.gap, self.gap_share, self.min_points, self.min_length
        )
        return segments_of(points, runs, lines)


def segments_of(points: FloatArray, runs: IntArray, lines: FloatArray) -> Segments:
    """Return segments of runs (M, 2) of points (N, 2) and their lines (rho, theta), shape (M, 2)."""
    rho, theta = lines.T
    normals = unit_vectors(theta)
    start, end = (
        points[at] - (np.sum(normals * points[at], axis=1) - rho)[:, None] * normals for at in (runs[:, 0], runs[:, 1])
    )
    return Segments(runs[:, 0], runs[:, 1], rho, theta, start, end)


@compiled
def _split_and_merge(
    points: FloatArray, max_distance: float, merge_distance: float, gap: float, gap_share: float, min_points: int,
    min_length: float,
) -> tuple[IntArray, FloatArray]:  # fmt: skip
    """Return runs (M, 2), both ends included, and their (rho, theta), shape (M, 2)."""
    N = len(points)
    runs = np.empty((N + 1, 2), np.int64)
    M = begin = 0
    for j in range(1, N + 1):
        if j == N or _is_gap(points, j, gap, gap_share):
            if j - begin >= 2:
                count = _split(points, begin, j - 1, max_distance, runs[M:])
                M += _merge(points, runs[M : M + count], merge_distance)
            begin = j
    kept = np.empty((M, 2), np.int64)
    lines = np.empty((M, 2))
    count = 0
    for m in range(M):
        first, last = runs[m]
        length = np.hypot(points[last, 0] - points[first, 0], points[last, 1] - points[first, 1])
        if last - first + 1 >= min_points and length >= min_length:
            kept[count] = runs[m]
            lines[count] = fitted_line(points, first, last)
            count += 1
    return kept[:count], lines[:count]


@compiled
def _is_gap(points: FloatArray, j: int, gap: float, gap_share: float) -> bool:
    """Return True if the points before j and at j are on different walls."""
    step = np.hypot(points[j, 0] - points[j - 1, 0], points[j, 1] - points[j - 1, 1])
    reach = min(np.hypot(points[j, 0], points[j, 1]), np.hypot(points[j - 1, 0], points[j - 1, 1]))
    return bool(step > gap + gap_share * reach)


@compiled
def _split(points: FloatArray, first: int, last: int, max_distance: float, runs: IntArray) -> int:
    """Split ``first`` to ``last`` by end-point fit, from left to right without recursion.

    It writes the runs, and returns their number.
    """
    stack = np.empty(last - first + 2, np.int64)
    stack[0] = last
    depth, begin, count = 1, first, 0
    while depth > 0:
        stop = stack[depth - 1]
        at, distance = _farthest(points, begin, stop)
        if distance > max_distance:
            stack[depth] = at
            depth += 1
        else:
            runs[count, 0], runs[count, 1] = begin, stop
            count += 1
            begin = stop
            depth -= 1
    return count


@compiled
def _farthest(points: FloatArray, first: int, last: int) -> tuple[int, float]:
    """Return the inner point farthest from the line through the end points, and its distance."""
    dx, dy = points[last, 0] - points[first, 0], points[last, 1] - points[first, 1]
    length = np.hypot(dx, dy)
    at, largest = first, 0.0
    for j in range(first + 1, last):
        x, y = points[j, 0] - points[first, 0], points[j, 1] - points[first, 1]
        distance = abs(dx * y - dy * x) / length if length > 0.0 else np.hypot(x, y)
        if distance > largest:
            at, largest = j, distance
    return at, largest


@compiled
def _merge(points: FloatArray, runs: IntArray, merge_distance: float) -> int:
    """Merge neighbours among the runs (M, 2) in place, from the left; return the number of runs left."""
    count = 0
    for m in range(1, len(runs)):
        rho, theta = fitted_line(points, runs[count, 0], runs[m, 1])
        c, s = np.cos(theta), np.sin(theta)
        together = True
        for j in range(runs[count, 0], runs[m, 1] + 1):
            if abs(points[j, 0] * c + points[j, 1] * s - rho) > merge_distance:
                together = False
                break
        if together:
            runs[count, 1] = runs[m, 1]
        else:
            count += 1
            runs[count] = runs[m]
    return count + 1


@compiled
def fitted_line(points: FloatArray, first: int, last: int) -> tuple[float, float]:
    """Return (rho, theta), rho >= 0, of the total-least-squares line through the points ``first`` to ``last``."""
    x, y = points[first : last + 1, 0].mean(), points[first : last + 1, 1].mean()
    xx = xy = yy = 0.0
    for j in range(first, last + 1):
        u, v = points[j, 0] - x, points[j, 1] - y
        xx, xy, yy = xx + u * u, xy + u * v, yy + v * v
    theta = 0.5 * np.arctan2(-2.0 * xy, yy - xx)
    rho = x * np.cos(theta) + y * np.sin(theta)
    if rho < 0.0:
        rho, theta = -rho, theta + np.pi
    return rho, wrapped(theta)
