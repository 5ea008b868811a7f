"""The segments of a scan by hopping and reverse hop: sections 3.2 and 3.3, Proc. 1 to 8, Fig. 5.

The procedure as printed, with the singular values of A_i(l) at every test; prefix_sums.py has its fast form. Points are
indexed from 0, and a run includes both its ends.
"""

from collections.abc import Callable
from itertools import pairwise
from math import isfinite
from typing import Final

import numpy as np

from slam.config import HoppingConfig
from slam.lines.hough_line import design_matrix, hough_line
from slam.lines.prefix_sums import runs_and_lines
from slam.lines.segments import IntArray, Segments
from slam.pose import FloatArray


def segments_by_hopping(points: FloatArray, config: HoppingConfig) -> Segments:
    """Find the segments of the points (N, 2) of one scan, in beam order, sensor frame: section 3.2.

    Points that are not finite are left out, and not counted in ``first`` and ``last``.
    """
    if not isfinite(np.vdot(points, points)):
        points = points[np.isfinite(points).all(axis=1)]
    if config.kernel == "prefix_sums":
        runs, lines = runs_and_lines(points, config.sigma_Th, config.psi, config.L_Th, config.split_gap)
    else:
        runs, lines = _by_svd(points, config)
    (first, last), (rho, theta) = runs.T, lines.T
    return Segments(first, last, rho, theta, points[first], points[last])  # Proc. 8


def sigma_3(points: FloatArray) -> float:
    """Compute the smallest singular value of A for points (l, 2), l >= 3: eqs. (6)-(8); metres."""
    return float(np.linalg.svd(design_matrix(points), compute_uv=False)[2])


def sigma_3_full(points: FloatArray) -> float:
    """Compute the same with all of U (l, l) and V, as in eq. (7): time and memory grow with l^2."""
    return float(np.linalg.svd(design_matrix(points), full_matrices=True)[1][2])


SIGMA_3: Final[dict[str, Callable[[FloatArray], float]]] = {"svd": sigma_3, "svd_full": sigma_3_full}


def hop_by_svd(
    points: FloatArray, sigma_Th: float, J: int, sigma_3: Callable[[FloatArray], float] = sigma_3
) -> list[tuple[int, int]]:
    """Find the runs (P_m, Q_m) of points (N, 2) that lie on lines; J is the hopping factor."""
    N, runs = len(points), []
    i, l, psi, previous = 0, 3, J, 2  # Proc. 1
    while i + 3 <= N:
        if i + l <= N and sigma_3(points[i : i + l]) < sigma_Th:  # Proc. 2 and 3; a hop past the end is a failed test
            previous, l = l, l + 1 + psi  # Proc. 4: hop over psi points; the printed l + 1 is for psi = 0
        elif l == 3:
            i, psi = i + 1, J  # three points that are not on a line: begin one point further on
        elif psi >= 1:
            l, psi = previous + 1, 0  # reverse hop, and no more hops on this segment
        else:
            runs.append((i, i + l - 2))  # Proc. 5
            i, l, psi = i + l - 2, 3, J  # Proc. 6: the end point is the next start point
    return runs


def _by_svd(points: FloatArray, config: HoppingConfig) -> tuple[IntArray, FloatArray]:
    """Find the runs (M, 2) and their (rho, theta), shape (M, 2), as printed."""
    cuts = np.flatnonzero(np.hypot(*np.diff(points, axis=0).T) > config.split_gap) + 1
    kept = [
        (begin + P, begin + Q)
        for begin, stop in pairwise([0, *cuts, len(points)])
        for P, Q in hop_by_svd(points[begin:stop], config.sigma_Th, config.psi, SIGMA_3[config.kernel])
        if Q - P + 1 > config.L_Th  # Proc. 7, which prints P - Q + 1
    ]
    lines = [hough_line(points[P : Q + 1])[:2] for P, Q in kept]
    return np.array(kept, dtype=np.int64).reshape(-1, 2), np.array(lines, dtype=np.float64).reshape(-1, 2)
