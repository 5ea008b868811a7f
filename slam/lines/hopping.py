"""Hopping and reverse hop: which runs of points lie on one line. Sections 3.2 and 3.3, Proc. 1 to 6, Fig. 5.

The procedure as printed, with the singular values of A_i(l) at every test; prefix_sums.py has its fast form. Points are
counted from 0, and a run includes both its ends.
"""

from __future__ import annotations

import numpy as np

from slam.lines.hough_line import design_matrix
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
