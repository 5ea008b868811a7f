"""The fast form of hopping: the same runs and lines from prefix sums, compiled.

sigma_3^2 is the smallest eigenvalue of A^T A, whose entries n, sum x, sum y, sum x^2, sum x y, sum y^2 are differences
of prefix sums over the scan: a test costs the same however many points it spans, and needs no eigen-solver.
"""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.lines.segments import IntArray
from slam.pose import FloatArray

X, Y, XX, XY, YY = range(5)
"""Columns of the sums (N + 1, 5): x, y, x^2, x y and y^2, summed over all points before each index."""


@compiled
def runs_and_lines(
    points: FloatArray, sigma_Th: float, J: int, L_Th: int, split_gap: float
) -> tuple[IntArray, FloatArray]:
    """Find the runs (M, 2) of points (N, 2), and their (rho, theta), shape (M, 2): Proc. 1 to 7."""
    sums = _prefix_sums(points)
    N = len(points)
    runs = np.empty((N, 2), np.int64)
    M = begin = 0
    for j in range(1, N):
        dx, dy = points[j, 0] - points[j - 1, 0], points[j, 1] - points[j - 1, 1]
        if dx * dx + dy * dy > split_gap * split_gap:
            M += _hop(sums, begin, j, sigma_Th, J, runs[M:])
            begin = j
    M += _hop(sums, begin, N, sigma_Th, J, runs[M:])
    kept = runs[:M][runs[:M, 1] - runs[:M, 0] + 1 > L_Th]  # Proc. 7
    lines = np.empty((len(kept), 2))
    for m in range(len(kept)):
        lines[m, 0], lines[m, 1] = _line_of_sums(sums, kept[m, 0], kept[m, 1])
    return kept, lines


@compiled
def _prefix_sums(points: FloatArray) -> FloatArray:
    """Return the sums (N + 1, 5) of points (N, 2)."""
    sums = np.zeros((len(points) + 1, 5))
    for j in range(len(points)):
        x, y = points[j, 0], points[j, 1]
        sums[j + 1, X] = sums[j, X] + x
        sums[j + 1, Y] = sums[j, Y] + y
        sums[j + 1, XX] = sums[j, XX] + x * x
        sums[j + 1, XY] = sums[j, XY] + x * y
        sums[j + 1, YY] = sums[j, YY] + y * y
    return sums


@compiled_on_views
def _fits_line(sums: FloatArray, i: int, l: int, sigma_Th: float) -> bool:
    """Test sigma_3 < sigma_Th for the l points from i, given their prefix sums.

    It holds exactly if A^T A - sigma_Th^2 I is not positive definite, which its three leading minors show.
    """
    threshold = sigma_Th * sigma_Th
    x, y = sums[i + l, X] - sums[i, X], sums[i + l, Y] - sums[i, Y]
    xx, xy = sums[i + l, XX] - sums[i, XX] - threshold, sums[i + l, XY] - sums[i, XY]
    yy, n = sums[i + l, YY] - sums[i, YY] - threshold, l - threshold
    minor = xx * yy - xy * xy
    return bool((xx <= 0.0) | (minor <= 0.0) | (n * minor <= x * x * yy - 2.0 * x * y * xy + y * y * xx))


@compiled_on_views
def _hop(sums: FloatArray, begin: int, stop: int, sigma_Th: float, J: int, runs: IntArray) -> int:
    """Write the runs among the points ``begin`` to ``stop`` (exclusive) to rows of ``runs``; return their number."""
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
    return M


@compiled_on_views
def _line_of_sums(sums: FloatArray, first: int, last: int) -> tuple[float, float]:
    """Fit (rho, theta) to the points ``first`` to ``last``: v_3 is the eigenvector of A^T A's smallest eigenvalue."""
    n, x, y = last - first + 1.0, sums[last + 1, X] - sums[first, X], sums[last + 1, Y] - sums[first, Y]
    xx, xy = sums[last + 1, XX] - sums[first, XX], sums[last + 1, XY] - sums[first, XY]
    yy = sums[last + 1, YY] - sums[first, YY]
    lam = _smallest_eigenvalue(xx, xy, yy, x, y, n)
    a, b, c = xx - lam, yy - lam, n - lam
    v0, v1, v2 = xy * y - b * x, xy * x - a * y, xy * xy - a * b  # v_3 is orthogonal to the first two rows
    w0, w1, w2 = b * c - y * y, x * y - xy * c, b * x - xy * y  # v_3 is orthogonal to the last two rows
    if w0 * w0 + w1 * w1 + w2 * w2 > v0 * v0 + v1 * v1 + v2 * v2:
        v0, v1, v2 = w0, w1, w2
    u0, u1, u2 = x * y - xy * c, a * c - x * x, a * y - xy * x
    if u0 * u0 + u1 * u1 + u2 * u2 > v0 * v0 + v1 * v1 + v2 * v2:
        v0, v1, v2 = u0, u1, u2
    if not v0 * v0 + v1 * v1 > 1e-24 * (xx + yy + n) ** 4:  # all points coincide: any line through them
        v0, v1, v2 = x / n, y / n, (x * x + y * y) / (n * n)
    alpha = np.copysign(1.0 / np.hypot(v0, v1), v2)  # eq. (12)
    return alpha * v2, np.arctan2(alpha * v1, alpha * v0)  # eq. (11)


@compiled_on_views
def _smallest_eigenvalue(xx: float, xy: float, yy: float, x: float, y: float, n: float) -> float:
    """Find the smallest eigenvalue of A^T A = [[xx, xy, -x], [xy, yy, -y], [-x, -y, n]] by Newton's method from 0.

    The iteration grows towards it.
    """
    trace = xx + yy + n
    minors = xx * yy - xy * xy + xx * n - x * x + yy * n - y * y
    determinant = n * (xx * yy - xy * xy) - x * x * yy + 2.0 * x * y * xy - y * y * xx
    lam = 0.0
    for _ in range(20):
        value = determinant - lam * (minors - lam * (trace - lam))
        slope = minors - lam * (2.0 * trace - 3.0 * lam)
        step = value / slope if slope > 0.0 else 0.0
        lam += step
        if step <= 1e-14 * trace:
            break
    return lam
