"""Prefix sums over the beams of a scan, which give the chi-square of any run of beams about its best line; compiled.

On the line a x + b y = 1 a beam of bearing t has 1/r = a cos(t) + b sin(t), which is linear in (a, b) for any
incidence. With range noise sigma_r the chi-square of a run is the least sum of q (1 - a x - b y)^2, where q = r^2 /
sigma_r^2, and six prefix sums give it for any run: q, q x, q y, q x^2, q x y, q y^2.
"""

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled_on_views
from slam.lines.range_noise import RangeNoise, range_variance
from slam.lines.segments import IntArray
from slam.pose import FloatArray
from slam.scan import BEARING, COS, SIN

Q, X, Y, XX, XY, YY = range(6)
"""Columns of the sums (N + 1, 6): q, q x, q y, q x^2, q x y and q y^2, summed over all points before each index."""
SUMS = 6
GAP = 0.05  # metres; a jump above GAP + 6 beam spacings + 3 sigma separates two walls
GAP_SPACINGS = 6.0
GAP_SIGMAS = 3.0


@compiled_on_views
def prefix_sums(
    ranges: FloatArray, fan: FloatArray, reach: tuple[float, float], noise: RangeNoise,
    sums: FloatArray, beam: IntArray, after_gap: NDArray[np.bool_],
) -> int:  # fmt: skip
    """Fill in the sums, the beam of each point, and True after a gap; return the number of points.

    The points are the beams with an echo.
    """
    n = 0
    q = qx = qy = qxx = qxy = qyy = 0.0
    last_x = last_y = last_bearing = last_r = 0.0
    sums[0] = 0.0
    for j in range(len(ranges)):
        r = ranges[j]
        if not (reach[0] <= r <= reach[1]):
            continue
        variance = range_variance(r, noise)
        x, y, w = r * fan[COS, j], r * fan[SIN, j], r * r / variance
        q, qx, qy = q + w, qx + w * x, qy + w * y
        qxx, qxy, qyy = qxx + w * x * x, qxy + w * x * y, qyy + w * y * y
        spacing = min(r, last_r) * abs(fan[BEARING, j] - last_bearing)
        gap = GAP + GAP_SPACINGS * spacing + GAP_SIGMAS * np.sqrt(2.0 * variance)
        after_gap[n] = (x - last_x) ** 2 + (y - last_y) ** 2 > gap * gap
        last_x, last_y, last_r, last_bearing = x, y, r, fan[BEARING, j]
        beam[n] = j
        n += 1
        sums[n, Q], sums[n, X], sums[n, Y] = q, qx, qy
        sums[n, XX], sums[n, XY], sums[n, YY] = qxx, qxy, qyy
    after_gap[0] = after_gap[n] = True
    return n


@compiled_on_views
def chi_square(sums: FloatArray, i: int, j: int) -> float:
    """Return chi-square of the points i to j (exclusive) about their best line; infinite if they lie in one bearing."""
    q, x, y = sums[j, Q] - sums[i, Q], sums[j, X] - sums[i, X], sums[j, Y] - sums[i, Y]
    xx, xy, yy = sums[j, XX] - sums[i, XX], sums[j, XY] - sums[i, XY], sums[j, YY] - sums[i, YY]
    determinant = xx * yy - xy * xy
    if determinant <= 1e-12 * xx * yy:
        return np.inf
    return float(q - (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant)
