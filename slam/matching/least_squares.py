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

from slam.compiled import compiled, wrapped
from slam.mapping.surfel_grid import Grid
from slam.matching.normal_equations import fill_normal_equations
from slam.pose import FloatArray

WIDE_ITERATIONS = 2  # in which a surfel may be a whole cell away
MIN_INFORMATION = 100.0  # m^-2: below it a direction is unconstrained


class SolverSettings(NamedTuple):
    """Settings of LeastSquaresConfig for the compiled loop, and the path for which small things count as new."""

    gate: float
    floor: float
    kernel: float
    first_kernel: float
    max_iterations: int
    tolerance: float
    lever: float
    weak: float
    standing_way: float


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
    scale = np.array([1.0, 1.0, settings.lever])
    L = _scaled(prior_information, settings.lever)
    projector, inliers, kernel, done, q = np.zeros((3, 3)), 0.0, settings.first_kernel, False, 0
    while q < settings.max_iterations and not done:
        wide = q < WIDE_ITERATIONS
        inliers = fill_normal_equations(
            facets, pose, grid, settings.gate, settings.floor, kernel, wide, settings.standing_way, H, g
        )
        q += 1
        A = _scaled(H, settings.lever)
        d = pose - prior
        d[2] = wrapped(d[2])
        d *= scale
        if _surely_constrained(A, settings.weak):
            projector = _identity()
            moved = _solved(A + L, g / scale - L @ d)
        else:
            B = _constrained(A, settings.weak)
            if B.shape[1] == 0:
                return Fit(prior.copy(), H, np.zeros((3, 3)), inliers, q, False)
            projector = B @ B.T
            a = B.T @ d  # the pose relative to the prior, in the constrained directions
            moved = B @ (a + np.linalg.solve(B.T @ (A + L) @ B, B.T @ (g / scale - L @ (B @ a)))) - d
        pose += moved / scale
        last_kernel, kernel = kernel, max(0.5 * kernel, settings.kernel)
        done = q > WIDE_ITERATIONS and last_kernel == kernel and np.abs(moved).sum() < settings.tolerance
    return Fit(pose, H, projector, inliers, q, done)


@compiled
def _scaled(information: FloatArray, lever: float) -> FloatArray:
    """Transform an information (3, 3) of x, y, theta to x, y, lever theta."""
    scaled = information.copy()
    for i in range(2):
        scaled[i, 2] /= lever
        scaled[2, i] /= lever
    scaled[2, 2] /= lever * lever
    return scaled


@compiled
def _identity() -> FloatArray:
    one = np.zeros((3, 3))
    one[0, 0] = one[1, 1] = one[2, 2] = 1.0
    return one


@compiled
def _surely_constrained(A: FloatArray, weak: float) -> bool:
    """Return True if surely no direction is weak: the least eigenvalue of three is at least 4 det / trace^2."""
    trace = A[0, 0] + A[1, 1] + A[2, 2]
    return bool(4.0 * _determinant(A) > max(weak * trace, MIN_INFORMATION) * trace * trace)


@compiled
def _constrained(A: FloatArray, weak: float) -> FloatArray:
    """Return an orthonormal basis (3, K) of the directions in which the information (3, 3) is not weak."""
    values, vectors = np.linalg.eigh(A)
    free = 0
    while free < 3 and (values[free] < weak * values[2] or values[free] < MIN_INFORMATION):
        free += 1
    return np.ascontiguousarray(vectors[:, free:])


@compiled
def _determinant(A: FloatArray) -> float:
    """Return the determinant of a symmetric (3, 3)."""
    minor_0, minor_1 = A[1, 1] * A[2, 2] - A[1, 2] * A[1, 2], A[0, 1] * A[2, 2] - A[1, 2] * A[0, 2]
    minor_2 = A[0, 1] * A[1, 2] - A[1, 1] * A[0, 2]
    return float(A[0, 0] * minor_0 - A[0, 1] * minor_1 + A[0, 2] * minor_2)


@compiled
def _solved(A: FloatArray, b: FloatArray) -> FloatArray:
    """Solve A x = b, for A (3, 3) symmetric and positive definite, by A = M M^T."""
    m = np.sqrt(A[0, 0])
    p, q = A[0, 1] / m, A[0, 2] / m
    n = np.sqrt(A[1, 1] - p * p)
    r = (A[1, 2] - p * q) / n
    o = np.sqrt(A[2, 2] - q * q - r * r)
    x = b[0] / m
    y = (b[1] - p * x) / n
    z = (b[2] - q * x - r * y) / o
    z /= o
    y = (y - r * z) / n
    return np.array([(x - p * y - q * z) / m, y, z])


@compiled
def fuse(
    predicted: FloatArray, motion: FloatArray, offset: FloatArray, information: FloatArray, projector: FloatArray,
    lever: float, correlation: float,
) -> tuple[FloatArray, float, FloatArray]:  # fmt: skip
    """Covariance (3, 3) after a match, its normalized innovation squared, and the unconstrained directions (K, 3).

    The information of the scan, over ``correlation``, counts only in the directions that it constrains. The innovation
    is the ``offset`` (3,) from the prior, squared under the covariance of the last ``motion`` alone and divided by the
    three dimensions, so that 1 is expected.
    """
    scale = np.array([1.0, 1.0, lever])
    constrained = projector.copy()
    for i in range(3):
        for j in range(3):
            constrained[i, j] *= scale[j] / scale[i]
    posterior = np.linalg.inv(np.linalg.inv(predicted) + constrained.T @ information @ constrained / correlation)
    expected = motion + correlation * np.linalg.inv(information + _identity())
    innovation_squared = offset @ np.linalg.solve(expected, offset) / 3.0
    values, vectors = np.linalg.eigh(projector)
    free = 0
    while free < 3 and values[free] < 0.5:
        free += 1
    return posterior, innovation_squared, np.ascontiguousarray(vectors[:, :free].T)  # type: ignore[return-value]  # of float64
