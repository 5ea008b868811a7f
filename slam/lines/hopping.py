"""Hopping and reverse hop: which runs of points lie on one line. Sections 3.2 and 3.3, Proc. 1 to 6, Fig. 5.

Two forms of the same procedure. ``hop_by_svd`` reads as printed and takes the singular values of A_i(l) at every test.
``hop_by_sums`` is compiled and asks the same question of A^T A, whose entries are differences of prefix sums: every
test costs the same however many points it spans, and needs no eigen-solver. Both count points from 0 and include both
ends.
"""

from __future__ import annotations

import numpy as np

from slam.compiled import compiled
from slam.lines.hough_line import design_matrix
from slam.lines.segments import IntArray
from slam.pose import FloatArray


def hop_by_svd(points: FloatArray, sigma_Th: float, J: int) -> list[tuple[int, int]]:
    """The runs (P_m, Q_m) of points (N, 2) that lie on lines; J is the hopping factor."""
    N, runs = len(points), []
    i, l, psi, previous = 0, 3, J, 2  # Proc. 1
    while i + 3 <= N:
        if i + l <= N and sigma_3(points[i : i + l]) < sigma_Th:  # Proc. 2 and 3
            previous, l = l, l + 1 + psi  # Proc. 4: hop over psi points
        elif l == 3:
            i, psi = i + 1, J  # three points that are no line: begin one point further
        elif psi >= 1:
            l, psi = previous + 1, 0  # reverse hop, and no more hops on this segment
        else:
            runs.append((i, i + l - 2))  # Proc. 5
            i, l, psi = i + l - 2, 3, J  # Proc. 6: the end point is the next start point
            if runs[-1][1] == N - 1:
                break
    return runs


def sigma_3(points: FloatArray) -> float:
    """The smallest singular value of A for points (l, 2), l >= 3: eqs. (6)-(8); metres."""
    return float(np.linalg.svd(design_matrix(points), compute_uv=False)[2])


@compiled
def prefix_sums(points: FloatArray) -> FloatArray:
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
def fits_line(sums: FloatArray, i: int, l: int, sigma_Th: float) -> bool:
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
def hop_by_sums(sums: FloatArray, begin: int, stop: int, sigma_Th: float, J: int, runs: IntArray) -> int:
    """The runs among the points ``begin`` to ``stop`` (exclusive), written to rows of ``runs``; returns how many."""
    M = 0
    i, l, psi, previous = begin, 3, J, 2  # Proc. 1
    while i + 3 <= stop:
        if i + l <= stop and fits_line(sums, i, l, sigma_Th):  # Proc. 2 and 3
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
