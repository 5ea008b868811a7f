"""The fast form of hopping: the same runs and lines from prefix sums, compiled.

sigma_3^2 is the smallest eigenvalue of A^T A, whose entries n, sum x, sum y, sum x^2, sum x y, sum y^2 are differences
of prefix sums over the scan: a test costs the same however many points it spans, and needs no eigen-solver.
"""

from __future__ import annotations

import numpy as np

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.pose import FloatArray


@compiled
def runs_and_lines(
    points: FloatArray, sigma_Th: float, J: int, L_Th: int, split_gap: float
) -> tuple[IntArray, FloatArray]:
    """Runs (M, 2) and their (rho, theta), shape (M, 2), of points (N, 2): Proc. 1 to 7."""
    sums = _prefix_sums(points)
    N = len(points)
    runs = np.empty((N, 2), np.int64)
    M = begin = 0
    for j in range(1, N + 1):
        if j == N or np.hypot(points[j, 0] - points[j - 1, 0], points[j, 1] - points[j - 1, 1]) > split_gap:
            M += _hop(sums, begin, j, sigma_Th, J, runs[M:])
            begin = j
    kept = runs[:M][runs[:M, 1] - runs[:M, 0] + 1 > L_Th]  # Proc. 7
    lines = np.empty((len(kept), 2))
    for m in range(len(kept)):
        lines[m] = _line_of_sums(sums, kept[m, 0], kept[m, 1])
    return kept, lines


@compiled
def _prefix_sums(points: FloatArray) -> FloatArray:
    """Sums over the points (N, 2) before each place of x, y, x^2, x y, y^2; shape (N + 1, 5)."""
    sums = np.zeros((len(points) + 1, 5))
    for j in range(len(points)):
        x, y = points[j, 0], points[j, 1]
        sums[j + 1, 0] = sums[j, 0] + x
        sums[j + 1, 1] = sums[j, 1] + y
        sums[j + 1, 2] = sums[j, 2] + x * x
        sums[j + 1, 3] = sums[j, 3] + x * y
        sums[j + 1, 4] = sums[j, 4] + y * y
    return sums


@compiled
def _fits_line(sums: FloatArray, i: int, l: int, sigma_Th: float) -> bool:
    """Whether sigma_3 < sigma_Th for the l points from i, given their prefix sums.

    It is exactly when A^T A - sigma_Th^2 I is not positive definite, which the three pivots of its elimination tell.
    """
    threshold = sigma_Th * sigma_Th
    x, y = sums[i + l, 0] - sums[i, 0], sums[i + l, 1] - sums[i, 1]
    xx, xy = sums[i + l, 2] - sums[i, 2] - threshold, sums[i + l, 3] - sums[i, 3]
    yy, n = sums[i + l, 4] - sums[i, 4] - threshold, l - threshold
    if xx <= 0.0:
        return True
    pivot_2 = yy - xy * xy / xx
    if pivot_2 <= 0.0:
        return True
    rest = y - xy * x / xx
    return bool(n - x * x / xx - rest * rest / pivot_2 <= 0.0)


@compiled
def _hop(sums: FloatArray, begin: int, stop: int, sigma_Th: float, J: int, runs: IntArray) -> int:
    """The runs among the points ``begin`` to ``stop`` (exclusive), written to rows of ``runs``; returns how many."""
    M = 0
    i, l, psi, previous = begin, 3, J, 2  # Proc. 1
    while i + 3 <= stop:
        if i + l <= stop and _fits_line(sums, i, l, sigma_Th):  # Proc. 2 and 3
            previous, l = l, l + 1 + psi  # Proc. 4
        elif l == 3:
            i, psi = i + 1, J
        elif psi >= 1:
            l, psi = previous + 1, 0  # reverse hop
        else:
            runs[M, 0], runs[M, 1] = i, i + l - 2  # Proc. 5
            M += 1
            i, l, psi = i + l - 2, 3, J  # Proc. 6
            if i == stop - 1:
                break
    return M


@compiled
def _line_of_sums(sums: FloatArray, first: int, last: int) -> FloatArray:
    """(rho, theta) of the points ``first`` to ``last``: v_3 is the eigenvector of A^T A to its smallest eigenvalue."""
    x, y, xx, xy, yy = sums[last + 1] - sums[first]
    _, V = np.linalg.eigh(np.array([[xx, xy, -x], [xy, yy, -y], [-x, -y, last - first + 1.0]]))
    v_3 = V[:, 0]  # eq. (10)
    alpha = np.copysign(1.0 / np.hypot(v_3[0], v_3[1]), v_3[2])  # eq. (12)
    return np.array([alpha * v_3[2], np.arctan2(alpha * v_3[1], alpha * v_3[0])])  # eq. (11)
