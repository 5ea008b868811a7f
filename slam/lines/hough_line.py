"""The line through a set of points, by SVD of the Hough line equation: section 3.1, eqs. (2)-(12)."""

from typing import NamedTuple

import numpy as np

from slam.pose import FloatArray


class HoughLine(NamedTuple):
    """The line x cos(theta) + y sin(theta) = rho, eq. (2), with rho >= 0; metres and radians."""

    rho: float
    theta: float
    sigma_3: float
    """The smallest singular value of A, metres: how far the points are from lying on one line.

    It is not the distance from the line: it grows with the root of the number of points, and because of the column of
    -1 it depends, like v_3, on the origin.
    """


def design_matrix(points: FloatArray) -> FloatArray:
    """Return A_i(l) of eq. (6) for points (l, 2): one row [x, y, -1] per point, eqs. (3) and (4)."""
    return np.column_stack([points, -np.ones(len(points))])


def hough_line(points: FloatArray) -> HoughLine:
    """Find the least-squares solution of A X = 0, eq. (5), for points (l, 2) with l >= 3, sensor frame, metres."""
    _, sigma, V_T = np.linalg.svd(design_matrix(points), full_matrices=False)  # eqs. (7) and (8)
    v_3 = V_T[2]  # eq. (10)
    alpha = np.copysign(1.0 / np.hypot(v_3[0], v_3[1]), v_3[2])  # eq. (12), with the sign that makes rho >= 0
    cos_theta, sin_theta, rho = alpha * v_3  # eqs. (9) and (11)
    return HoughLine(float(rho), float(np.arctan2(sin_theta, cos_theta)), float(sigma[2]))
