"""The line segments of a scan: Proc. 1 to 8."""

from __future__ import annotations

import numpy as np

from slam.compiled import compiled
from slam.config import LineConfig
from slam.lines.hopping import hop_by_sums, hop_by_svd, prefix_sums
from slam.lines.hough_line import hough_line
from slam.lines.segments import IntArray, Segments
from slam.pose import FloatArray


def extract_segments(points: FloatArray, config: LineConfig) -> Segments:
    """Segments of the points (N, 2) of one scan, in beam order, sensor frame: section 3.2."""
    if config.kernel == "svd":
        runs, lines = _by_svd(points, config)
    else:
        runs, lines = _by_sums(points, config.sigma_Th, config.psi, config.L_Th, config.split_gap)
    first, last = runs[:, 0], runs[:, 1]
    return Segments(first, last, lines[:, 0], lines[:, 1], points[first], points[last])  # Proc. 8


def _by_svd(points: FloatArray, config: LineConfig) -> tuple[IntArray, FloatArray]:
    """Runs (M, 2) and their (rho, theta), shape (M, 2), as printed."""
    kept = [
        (begin + P, begin + Q)
        for begin, stop in zip(*_pieces(points, config.split_gap), strict=True)
        for P, Q in hop_by_svd(points[begin:stop], config.sigma_Th, config.psi)
        if Q - P + 1 > config.L_Th  # Proc. 7
    ]
    lines = [hough_line(points[P : Q + 1])[:2] for P, Q in kept]
    return np.array(kept, dtype=np.int64).reshape(-1, 2), np.array(lines, dtype=np.float64).reshape(-1, 2)


def _pieces(points: FloatArray, split_gap: float) -> tuple[IntArray, IntArray]:
    """Begins and stops of the pieces without a step longer than ``split_gap`` metres."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    cuts = np.flatnonzero(steps > split_gap) + 1
    return np.concatenate([[0], cuts]), np.concatenate([cuts, [len(points)]])


@compiled
def _by_sums(points: FloatArray, sigma_Th: float, J: int, L_Th: int, split_gap: float) -> tuple[IntArray, FloatArray]:
    """The same, compiled: every test from prefix sums, one 3 x 3 eigenproblem a kept segment."""
    sums = prefix_sums(points)
    N = len(points)
    runs = np.empty((N, 2), np.int64)
    M = begin = 0
    for j in range(1, N + 1):
        if j == N or np.hypot(points[j, 0] - points[j - 1, 0], points[j, 1] - points[j - 1, 1]) > split_gap:
            M += hop_by_sums(sums, begin, j, sigma_Th, J, runs[M:])
            begin = j
    kept = runs[:M][runs[:M, 1] - runs[:M, 0] + 1 > L_Th]  # Proc. 7
    lines = np.empty((len(kept), 2))
    for m in range(len(kept)):
        lines[m] = _line_of_sums(sums, kept[m, 0], kept[m, 1])
    return kept, lines


@compiled
def _line_of_sums(sums: FloatArray, first: int, last: int) -> FloatArray:
    """(rho, theta) of the points ``first`` to ``last``: v_3 is the eigenvector of A^T A to its smallest eigenvalue."""
    x, y, xx, xy, yy = sums[last + 1] - sums[first]
    _, V = np.linalg.eigh(np.array([[xx, xy, -x], [xy, yy, -y], [-x, -y, last - first + 1.0]]))
    v_3 = V[:, 0]  # eq. (10)
    alpha = np.copysign(1.0 / np.hypot(v_3[0], v_3[1]), v_3[2])  # eq. (12)
    return np.array([alpha * v_3[2], np.arctan2(alpha * v_3[1], alpha * v_3[0])])  # eq. (11)
