"""Match of a scan's facets to the map's surfels: Gauss-Newton with a robust kernel and a prior, compiled.

Pose, facet f and surfel s give the residual r = n_s . (R f + t - c_s) along the surfel's normal, or the whole offset
for a cluster. Its variance is v = v_f + v_s + floor^2, its weight 1 / (v (1 + r^2 / (kernel^2 + v))^2), which is that
of Geman and McClure. At every iteration a facet is matched again to the nearest surfel that faces the same way, while
the kernel shrinks.

A step is taken only in the directions that the scan constrains: the eigenvectors of its own information, with rotation
scaled by a lever, whose eigenvalue is not a small share of the largest. In the others the pose of the prior is kept.
"""

from typing import NamedTuple

import numpy as np

from slam.compiled import compiled, compiled_on_views, wrapped
from slam.mapping.surfel_grid import Grid
from slam.matching.normal_equations import fill_normal_equations
from slam.pose import FloatArray
from slam.small_matrices import identity, inverse, principal_axes, product, solved, times

WIDE_ITERATIONS = 2  # first iterations, in which a surfel may be a whole cell away
MIN_INFORMATION = 100.0  # m^-2: below it a direction is unconstrained


class SolverSettings(NamedTuple):
    """Settings for the compiled loop; all but the last are keys of LeastSquaresConfig."""

    gate: float
    floor: float
    kernel: float
    first_kernel: float
    max_iterations: int
    tolerance: float
    lever: float
    weak: float
    standing_length: float
    """Motion of the sensor, metres and radians, until a small thing counts as standing; 0 if all things stand."""


class Fit(NamedTuple):
    """The pose that fits best, and the information of the scan."""

    pose: FloatArray
    """(3,): x, y, theta of the sensor."""
    information: FloatArray
    """(3, 3): information of the scan alone."""
    projector: FloatArray
    """(3, 3): projector onto the directions that the scan constrains, in (x, y, lever theta)."""
    inliers: float
    """Sum of the weights of the facets that agree with the map."""
    iterations: int
    converged: bool


@compiled
def solve(
    facets: FloatArray, start: FloatArray, prior: FloatArray, prior_information: FloatArray, grid: Grid,
    settings: SolverSettings,
) -> Fit:  # fmt: skip
    """Find the pose of the sensor that fits best from ``start`` (3,), given a prior (3,) and its information (3, 3)."""
    pose, H, g = start.copy(), np.zeros((3, 3)), np.zeros(3)
    L = _scaled(prior_information, settings.lever)
    projector, inliers, kernel, done, q = np.zeros((3, 3)), 0.0, settings.first_kernel, False, 0
    while q < settings.max_iterations and not done:
        wide = q < WIDE_ITERATIONS
        inliers = fill_normal_equations(
            facets, pose, grid, settings.gate, settings.floor, kernel, wide, settings.standing_length, H, g
        )
        q += 1
        A = _scaled(H, settings.lever)
        projector = _projector(A, settings.weak)
        if projector[0, 0] + projector[1, 1] + projector[2, 2] == 0.0:
            return Fit(prior.copy(), H, projector, inliers, q, False)
        g[2] /= settings.lever
        moved = _step(A, g, L, _offset(pose, prior, settings.lever), projector)
        pose[0] += moved[0]
        pose[1] += moved[1]
        pose[2] += moved[2] / settings.lever
        last_kernel, kernel = kernel, max(0.5 * kernel, settings.kernel)
        way = abs(moved[0]) + abs(moved[1]) + abs(moved[2])
        done = q > WIDE_ITERATIONS and last_kernel == kernel and way < settings.tolerance
    return Fit(pose, H, projector, inliers, q, done)


@compiled
def _scaled(information: FloatArray, lever: float) -> FloatArray:
    """Transform an information (3, 3) of x, y, theta to x, y, lever theta."""
    scaled = information.copy()
    for i in range(3):
        scaled[i, 2] /= lever
        scaled[2, i] /= lever
    return scaled


@compiled
def _offset(pose: FloatArray, prior: FloatArray, lever: float) -> FloatArray:
    """Return a pose relative to the prior, (3,): x, y, lever theta."""
    offset = np.empty(3)
    offset[0], offset[1], offset[2] = pose[0] - prior[0], pose[1] - prior[1], lever * wrapped(pose[2] - prior[2])
    return offset


@compiled
def _projector(A: FloatArray, weak: float) -> FloatArray:
    """Return the projector (3, 3) onto the directions in which the information (3, 3) is not weak."""
    if _surely_constrained(A, weak):
        return identity()
    values, vectors = principal_axes(A)
    least = max(weak * max(values[0], values[1], values[2]), MIN_INFORMATION)
    projector = np.zeros((3, 3))
    for k in range(3):
        if values[k] >= least:
            for i in range(3):
                for j in range(3):
                    projector[i, j] += vectors[i, k] * vectors[j, k]
    return projector


@compiled_on_views
def _surely_constrained(A: FloatArray, weak: float) -> bool:
    """Return True if surely no direction is weak: the least eigenvalue of three is at least 4 det / trace^2."""
    trace = A[0, 0] + A[1, 1] + A[2, 2]
    return bool(4.0 * _determinant(A) > max(weak * trace, MIN_INFORMATION) * trace * trace)


@compiled_on_views
def _determinant(A: FloatArray) -> float:
    """Return the determinant of a symmetric (3, 3)."""
    minor_0, minor_1 = A[1, 1] * A[2, 2] - A[1, 2] * A[1, 2], A[0, 1] * A[2, 2] - A[1, 2] * A[0, 2]
    minor_2 = A[0, 1] * A[1, 2] - A[1, 1] * A[0, 2]
    return float(A[0, 0] * minor_0 - A[0, 1] * minor_1 + A[0, 2] * minor_2)


@compiled
def _step(A: FloatArray, g: FloatArray, L: FloatArray, d: FloatArray, P: FloatArray) -> FloatArray:
    """Return the step (3,) to the best fit in the directions of a projector, from ``d`` (3,) relative to the prior.

    The fit is at P d + x, with x in those directions and P (A + L) P x = P (g - L P d).
    """
    inside = times(P, d)
    M, pull = _within(P, A), times(L, inside)
    prior = _within(P, L)
    for i in range(3):
        M[i, i] += 1.0
        pull[i] = g[i] - pull[i]
        for j in range(3):
            M[i, j] += prior[i, j] - P[i, j]  # the identity across the directions, so that M has an inverse
    x = solved(M, times(P, pull))
    for i in range(3):
        x[i] += inside[i] - d[i]
    return x


@compiled
def _within(P: FloatArray, information: FloatArray) -> FloatArray:
    """Return P I P (3, 3): the part of an information in the directions of a projector."""
    return product(product(P, information), P)


@compiled
def fuse(
    predicted: FloatArray, motion: FloatArray, offset: FloatArray, information: FloatArray, projector: FloatArray,
    lever: float, correlation: float,
) -> tuple[FloatArray, float, FloatArray]:  # fmt: skip
    """Covariance (3, 3) after a match, its normalized innovation squared, and the unconstrained directions (K, 3).

    The information of the scan, divided by ``correlation``, counts only in the directions that it constrains. The
    innovation is the ``offset`` (3,) from the prior. It is normalized by the covariance of the last ``motion`` and of
    the scan, and divided by its three dimensions, so that its expected value is 1.
    """
    scan_information = _scaled(_within(projector, _scaled(information, lever)), 1.0 / lever)
    fused, expected, settled = inverse(predicted), motion.copy(), information.copy()
    for i in range(3):
        settled[i, i] += 1.0
    by_scan = inverse(settled)
    for i in range(3):
        for j in range(3):
            fused[i, j] += scan_information[i, j] / correlation
            expected[i, j] += correlation * by_scan[i, j]
    surprise = solved(expected, offset)
    innovation_squared = (offset[0] * surprise[0] + offset[1] * surprise[1] + offset[2] * surprise[2]) / 3.0
    return inverse(fused), innovation_squared, _unconstrained(projector)


@compiled
def _unconstrained(projector: FloatArray) -> FloatArray:
    """Return the directions (K, 3) orthogonal to those of a projector (3, 3)."""
    values, vectors = principal_axes(projector)
    directions, count = np.empty((3, 3)), 0
    for k in range(3):
        if values[k] < 0.5:
            for i in range(3):
                directions[count, i] = vectors[i, k]
            count += 1
    return directions[:count]
