"""A scan's facets to the map's surfels: Gauss-Newton with a robust kernel and the prior, compiled.

Pose, facet f and surfel s give the residual r = n_s . (R f + t - c_s) along the surfel's normal, or the whole offset
for a cluster. Its variance is v = v_f + v_s + floor^2, its weight 1 / (v (1 + r^2 / (kernel^2 + v))^2), which is Geman
and McClure's. A facet is matched to the nearest surfel that faces its way, anew at every iteration, while the kernel
shrinks.

A step is taken only in the directions that the scan constrains: those eigenvectors of its own information, turns
counted as motion of a lever, whose eigenvalue is not a small share of the largest. In the others the prior stands.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from slam.compiled import compiled
from slam.mapping.surfel_grid import Grid
from slam.pose import FloatArray

SAME_WAY = 0.85  # cosine between the normals of a facet and of its surfel
ALONG = 0.1  # what a square metre along the wall counts in choosing a surfel, against one across
CLUSTER_SIZE = 0.03  # metres: what a cluster shows of itself differs from place to place
WIDE = 2  # iterations in which a surfel may be a whole cell away
LEAST_INFORMATION = 100.0  # m^-2: below it a scan says nothing of a direction


class Settings(NamedTuple):
    """Of LeastSquaresConfig, what the compiled loop needs."""

    gate: float
    floor: float
    kernel: float
    first_kernel: float
    max_iterations: int
    tolerance: float
    lever: float
    weak: float


@compiled
def solve(
    facets: FloatArray, start: FloatArray, prior: FloatArray, prior_information: FloatArray, grid: Grid,
    settings: Settings,
) -> tuple[FloatArray, FloatArray, FloatArray, float, int, bool]:  # fmt: skip
    """From ``start`` (3,) the pose of the sensor that fits best, given the prior (3,) and its information (3, 3).

    Returns the pose (3,), the information of the scan alone (3, 3), the projector (3, 3) onto the directions that it
    constrains, in (x, y, lever theta), the weight of the facets that agree, iterations, and whether they converged.
    """
    pose, H, g = start.copy(), np.zeros((3, 3)), np.zeros(3)
    scale = np.array([1.0, 1.0, settings.lever])
    L = prior_information / np.outer(scale, scale)
    projector, inliers, kernel, done, q = np.zeros((3, 3)), 0.0, settings.first_kernel, False, 0
    while q < settings.max_iterations and not done:
        inliers = _normal_equations(facets, pose, grid, settings, kernel, q < WIDE, H, g)
        q += 1
        A = H / np.outer(scale, scale)
        d = pose - prior
        d[2] -= 2.0 * np.pi * np.floor(d[2] / (2.0 * np.pi) + 0.5)
        d *= scale
        if _surely_constrained(A, settings.weak):
            projector = np.eye(3)
            moved = _solved(A + L, g / scale - L @ d)
        else:
            B = _constrained(A, settings.weak)
            if B.shape[1] == 0:
                return prior.copy(), H, np.zeros((3, 3)), inliers, q, False
            projector = B @ B.T
            a = B.T @ d  # where the pose is, seen from the prior, in the directions that are constrained
            moved = B @ (a + np.linalg.solve(B.T @ (A + L) @ B, B.T @ (g / scale - L @ (B @ a)))) - d
        pose += moved / scale
        last_kernel, kernel = kernel, max(0.5 * kernel, settings.kernel)
        done = q > WIDE and last_kernel == kernel and np.abs(moved).sum() < settings.tolerance
    return pose, H, projector, inliers, q, done


@compiled
def _surely_constrained(A: FloatArray, weak: float) -> bool:
    """Whether no direction can be weak, told without eigenvalues: the least of three is at least 4 det / trace^2."""
    trace = A[0, 0] + A[1, 1] + A[2, 2]
    return bool(4.0 * _determinant(A) > max(weak * trace, LEAST_INFORMATION) * trace * trace)


@compiled
def _constrained(A: FloatArray, weak: float) -> FloatArray:
    """An orthonormal basis (3, K) of the directions in which the information (3, 3) is not weak."""
    values, vectors = np.linalg.eigh(A)
    free = 0
    while free < 3 and (values[free] < weak * values[2] or values[free] < LEAST_INFORMATION):
        free += 1
    return np.ascontiguousarray(vectors[:, free:])


@compiled
def _determinant(A: FloatArray) -> float:
    """Of a symmetric (3, 3)."""
    minor_0, minor_1 = A[1, 1] * A[2, 2] - A[1, 2] * A[1, 2], A[0, 1] * A[2, 2] - A[1, 2] * A[0, 2]
    minor_2 = A[0, 1] * A[1, 2] - A[1, 1] * A[0, 2]
    return float(A[0, 0] * minor_0 - A[0, 1] * minor_1 + A[0, 2] * minor_2)


@compiled
def _solved(A: FloatArray, b: FloatArray) -> FloatArray:
    """x of A x = b, for A (3, 3) symmetric and positive definite, by A = M M^T."""
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
    """Covariance (3, 3) after a match, how much it surprises, and the unconstrained directions (K, 3).

    The information of the scan, over ``correlation``, counts only in the directions that it constrains. The surprise is
    that of the ``offset`` (3,) from the prior under the covariance of the last ``motion`` alone: 1 on average.
    """
    scale = np.array([1.0, 1.0, lever])
    keep = projector * np.outer(1.0 / scale, scale)
    posterior = np.linalg.inv(np.linalg.inv(predicted) + keep.T @ information @ keep / correlation)
    expected = motion + correlation * np.linalg.inv(information + np.eye(3))
    surprise = offset @ np.linalg.solve(expected, offset) / 3.0
    values, vectors = np.linalg.eigh(projector)
    free = 0
    while free < 3 and values[free] < 0.5:
        free += 1
    return posterior, surprise, np.ascontiguousarray(vectors[:, :free].T)  # type: ignore[return-value]  # of float64


@compiled
def _normal_equations(
    facets: FloatArray, pose: FloatArray, grid: Grid, settings: Settings, kernel: float, wide: bool, H: FloatArray,
    g: FloatArray,
) -> float:  # fmt: skip
    """Fill H (3, 3) and g (3,) for x, y, theta; returns the sum of the robust weights, which is at most 1 a facet."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    H[:] = 0.0
    g[:] = 0.0
    inliers = 0.0
    for f in range(len(facets)):
        lx, ly = c * facets[f, 0] - s * facets[f, 1], s * facets[f, 0] + c * facets[f, 1]
        nx, ny = c * facets[f, 2] - s * facets[f, 3], s * facets[f, 2] + c * facets[f, 3]
        x, y = pose[0] + lx, pose[1] + ly
        k = _nearest(x, y, nx, ny, grid, settings.gate, wide)
        if k < 0:
            continue
        surfel = grid.surfels[k]
        dx, dy = x - surfel[0], y - surfel[1]
        v = facets[f, 4] + settings.floor**2 + 1.0 / surfel[4]
        if nx != 0.0 or ny != 0.0:
            inliers += _along(surfel[2], surfel[3], dx, dy, lx, ly, v, kernel, H, g)
        else:
            v += CLUSTER_SIZE**2
            t = (dx * dx + dy * dy) / (kernel * kernel + v)
            inliers += 1.0 / (1.0 + t) ** 2
            v *= (1.0 + t) ** 2
            _along(1.0, 0.0, dx, 0.0, lx, ly, v, np.inf, H, g)
            _along(0.0, 1.0, 0.0, dy, lx, ly, v, np.inf, H, g)
    H[1, 0], H[2, 0], H[2, 1] = H[0, 1], H[0, 2], H[1, 2]
    return inliers


@compiled
def _along(
    nx: float, ny: float, dx: float, dy: float, lx: float, ly: float, v: float, kernel: float, H: FloatArray,
    g: FloatArray,
) -> float:  # fmt: skip
    """Add one residual along a normal, at the lever (lx, ly) from the sensor; returns its robust weight."""
    r, jt = dx * nx + dy * ny, lx * ny - ly * nx
    robust = 1.0 / (1.0 + r * r / (kernel * kernel + v)) ** 2
    w = robust / v
    H[0, 0] += w * nx * nx
    H[0, 1] += w * nx * ny
    H[1, 1] += w * ny * ny
    H[0, 2] += w * nx * jt
    H[1, 2] += w * ny * jt
    H[2, 2] += w * jt * jt
    g[0] -= w * r * nx
    g[1] -= w * r * ny
    g[2] -= w * r * jt
    return robust


@compiled
def _nearest(x: float, y: float, nx: float, ny: float, grid: Grid, gate: float, wide: bool) -> int:
    """The surfel for a facet, -1 for none: among the four nearest cells, or in the nine around where it is wide."""
    u, v = x / grid.cell, y / grid.cell
    row, column = int(np.floor(v)), int(np.floor(u))
    low_row = row - 1 if wide or v - row < 0.5 else row
    low_column = column - 1 if wide or u - column < 0.5 else column
    span = 3 if wide else 2
    low_row, low_column = low_row - grid.corner[0], low_column - grid.corner[1]
    rows, columns = grid.head.shape
    wall = nx != 0.0 or ny != 0.0
    best, least = -1, np.inf
    for i in range(max(low_row, 0), min(low_row + span, rows)):
        for j in range(max(low_column, 0), min(low_column + span, columns)):
            k = grid.head[i, j]
            while k >= 0:
                s = grid.surfels[k]
                if wall == (s[2] != 0.0 or s[3] != 0.0):
                    dx, dy = x - s[0], y - s[1]
                    across = abs(dx * s[2] + dy * s[3]) if wall else np.sqrt(dx * dx + dy * dy)
                    cost = across * across + ALONG * (dx * dx + dy * dy)
                    if across < gate and cost < least and (not wall or nx * s[2] + ny * s[3] > SAME_WAY):
                        best, least = k, cost
                k = grid.next[k]
    return best
