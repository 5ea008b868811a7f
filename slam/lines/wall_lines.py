"""The lines through runs of beams that saw one wall each, their end points and covariance; compiled."""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.lines.beam_sums import XX, XY, YY, X, Y
from slam.lines.segments import IntArray
from slam.lines.wall_runs import FIRST_BEAM, MEETS_NEXT
from slam.pose import FloatArray
from slam.scan import COS, SIN

RHO, THETA = range(2)
"""Columns of the lines (K, 2)."""
START, END = range(2)
"""Indices of the two ends of a line."""
AA, AB, BB = range(3)
"""Columns of the covariance of (a, b), of the line a x + b y = 1."""
CORNER_DISTANCE = 0.10  # metres: lines of neighbouring runs that cross this near their boundary form a corner
CORNER_STEPS = 2.0  # added to that distance, in spacings of neighbouring points
MIN_CORNER_SINE = 0.2  # sine of the least angle between these lines


@compiled
def wall_lines(
    runs: IntArray, totals: FloatArray, fan: FloatArray, spacing: float, min_length: float, max_angle_sigma: float
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Fit lines to the runs (M, 5) and sums (M, 6) of wall_runs.py, and keep those long and sure enough: K of them.

    ``spacing`` is the angle between two beams. Returns the rows kept (K,), [rho, theta] (K, 2), their covariance
    (K, 2, 2), start and end points (K, 2, 2) and the covariance of each, shape (K, 2, 2, 2); metres and radians.
    """
    M = len(runs)
    kept, line, line_cov = np.empty(M, np.int64), np.empty((M, 2)), np.empty((M, 2, 2))
    ends, ends_cov = np.empty((M, 2, 2)), np.empty((M, 2, 2, 2))
    ab, ab_cov = np.empty((M, 2)), np.empty((M, 3))
    K = 0
    for m in range(M):
        if not _solve(totals[m], ab[K], ab_cov[K]):
            continue
        _polar(ab[K], ab_cov[K], line[K], line_cov[K])
        for e in (START, END):
            beam = runs[m, FIRST_BEAM + e]
            _end(ab[K], ab_cov[K], fan[COS, beam], fan[SIN, beam], spacing, ends[K, e], ends_cov[K, e])
        dx, dy = ends[K, END, 0] - ends[K, START, 0], ends[K, END, 1] - ends[K, START, 1]
        sure = line_cov[K, THETA, THETA] <= max_angle_sigma * max_angle_sigma
        if sure and dx * dx + dy * dy >= min_length * min_length:  # false for a NaN
            kept[K] = m
            K += 1
    for k in range(K - 1):
        if kept[k + 1] == kept[k] + 1 and runs[kept[k], MEETS_NEXT]:
            _corner(ab[k : k + 2], ab_cov[k : k + 2], spacing, ends[k : k + 2], ends_cov[k : k + 2])
    return kept[:K], line[:K], line_cov[:K], ends[:K], ends_cov[:K]


@compiled_on_views
def _solve(totals: FloatArray, ab: FloatArray, cov: FloatArray) -> bool:
    """Solve for (a, b) of a x + b y = 1 and its covariance from the six sums; False if they are singular."""
    x, y, xx, xy, yy = totals[X], totals[Y], totals[XX], totals[XY], totals[YY]
    determinant = xx * yy - xy * xy
    if not determinant > 1e-12 * xx * yy:
        return False
    ab[0], ab[1] = (yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant
    cov[AA], cov[AB], cov[BB] = yy / determinant, -xy / determinant, xx / determinant
    return True


@compiled_on_views
def _polar(ab: FloatArray, cov: FloatArray, line: FloatArray, line_cov: FloatArray) -> None:
    """Convert (a, b) and its covariance to [rho, theta]: rho = 1 / |(a, b)|, theta = atan2(b, a)."""
    a, b = ab[0], ab[1]
    rho = 1.0 / np.sqrt(a * a + b * b)
    line[RHO], line[THETA] = rho, np.arctan2(b, a)
    ra, rb = -a * rho**3, -b * rho**3
    ta, tb = -b * rho**2, a * rho**2
    aa, ab_, bb = cov[AA], cov[AB], cov[BB]
    line_cov[RHO, RHO] = ra * ra * aa + 2.0 * ra * rb * ab_ + rb * rb * bb
    line_cov[THETA, THETA] = ta * ta * aa + 2.0 * ta * tb * ab_ + tb * tb * bb
    line_cov[RHO, THETA] = line_cov[THETA, RHO] = ra * ta * aa + (ra * tb + rb * ta) * ab_ + rb * tb * bb


@compiled_on_views
def _end(
    ab: FloatArray, cov: FloatArray, c: float, s: float, spacing: float, end: FloatArray, end_cov: FloatArray
) -> None:
    """Write the intersection of the line with the beam of this cosine and sine, and its covariance.

    Its uncertainty along the beam is that of the line. Along the line, the wall ends anywhere up to the next beam: the
    mean square of that error is a third of the squared distance to it.
    """
    a, b = ab[0], ab[1]
    r = 1.0 / (a * c + b * s)
    end[0], end[1] = (r * c, r * s) if r > 0.0 else (np.nan, np.nan)
    along_beam = r**4 * (c * c * cov[AA] + 2.0 * c * s * cov[AB] + s * s * cov[BB])
    step_x, step_y = -b * r * r * spacing, a * r * r * spacing  # d(end)/d(bearing) times the spacing
    end_cov[0, 0] = along_beam * c * c + step_x * step_x / 3.0
    end_cov[1, 1] = along_beam * s * s + step_y * step_y / 3.0
    end_cov[0, 1] = end_cov[1, 0] = along_beam * c * s + step_x * step_y / 3.0


@compiled_on_views
def _corner(ab: FloatArray, cov: FloatArray, spacing: float, ends: FloatArray, ends_cov: FloatArray) -> None:
    """End two neighbours at their intersection, with the covariance that follows from both lines."""
    a0, b0, a1, b1 = ab[0, 0], ab[0, 1], ab[1, 0], ab[1, 1]
    cross = a0 * b1 - a1 * b0
    if cross * cross < MIN_CORNER_SINE**2 * (a0 * a0 + b0 * b0) * (a1 * a1 + b1 * b1):
        return
    x, y = (b1 - b0) / cross, (a0 - a1) / cross
    for k in range(2):
        end_x, end_y = ends[k, 1 - k, 0], ends[k, 1 - k, 1]
        step = (end_x * end_x + end_y * end_y) * np.hypot(ab[k, 0], ab[k, 1]) * abs(spacing)
        if np.hypot(x - end_x, y - end_y) > CORNER_DISTANCE + CORNER_STEPS * step:
            return
    v0 = (x * x * cov[0, AA] + 2.0 * x * y * cov[0, AB] + y * y * cov[0, BB]) / (cross * cross)
    v1 = (x * x * cov[1, AA] + 2.0 * x * y * cov[1, AB] + y * y * cov[1, BB]) / (cross * cross)
    for k in range(2):
        ends[k, 1 - k, 0], ends[k, 1 - k, 1] = x, y
        ends_cov[k, 1 - k, 0, 0] = b1 * b1 * v0 + b0 * b0 * v1
        ends_cov[k, 1 - k, 1, 1] = a1 * a1 * v0 + a0 * a0 * v1
        ends_cov[k, 1 - k, 0, 1] = ends_cov[k, 1 - k, 1, 0] = -a1 * b1 * v0 - a0 * b0 * v1
