"""Pairs of facets and surfels, and the normal equations of their residuals, compiled: see least_squares.py.

Small new things in the map may be moving: the legs of people, which in a corridor are often the only features along it.
Such facets are used as if all had moved by one unknown shift since they were seen, which is eliminated.
"""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.lines.facets import LINKED, NX, NY, VARIANCE, X, Y
from slam.mapping.surfel_grid import BORN, INFORMATION, Grid
from slam.pose import FloatArray

PAIR_COSINE = 0.85  # least cosine between the normals of a facet and of its surfel
ALONG_WEIGHT = 0.1  # weight of squared distances along the wall when a surfel is chosen; across: 1
CLUSTER_SIGMA = 0.03  # metres by which the echoes of a cluster vary
SHIFT_SIGMA = 0.05  # metres by which small things may have moved since, all together


@compiled
def fill_normal_equations(
    facets: FloatArray, pose: FloatArray, grid: Grid, gate: float, floor: float, kernel: float, wide: bool,
    standing_length: float, H: FloatArray, g: FloatArray,
) -> float:  # fmt: skip
    """Fill H (3, 3) and g (3,) for x, y, theta; return the sum of the robust weights, each of which is at most 1.

    A facet is paired with a surfel nearer than ``gate``, metres, up to a whole cell away where the search is ``wide``.
    A small thing counts as new until the sensor has moved ``standing_length`` since it was first seen.
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    H[:] = 0.0
    g[:] = 0.0
    surfels, inliers, H_new, g_new = grid.surfels, 0.0, np.zeros((3, 3)), np.zeros(3)
    for f in range(len(facets)):
        fx, fy, fnx, fny = facets[f, X], facets[f, Y], facets[f, NX], facets[f, NY]
        lx, ly = c * fx - s * fy, s * fx + c * fy
        nx, ny = c * fnx - s * fny, s * fnx + c * fny
        x, y = pose[0] + lx, pose[1] + ly
        k = _nearest(x, y, nx, ny, grid, gate, wide)
        if k < 0:
            continue
        dx, dy = x - surfels[k, X], y - surfels[k, Y]
        v = facets[f, VARIANCE] + floor**2 + 1.0 / surfels[k, INFORMATION]
        is_new = grid.path_length - surfels[k, BORN] < standing_length
        to_H, to_g = (H_new, g_new) if is_new and _is_alone(facets, f) else (H, g)
        if nx != 0.0 or ny != 0.0:
            inliers += _add_residual(surfels[k, NX], surfels[k, NY], dx, dy, lx, ly, v, kernel, to_H, to_g)
        else:
            v += CLUSTER_SIGMA**2
            t = (dx * dx + dy * dy) / (kernel * kernel + v)
            inliers += 1.0 / (1.0 + t) ** 2
            v *= (1.0 + t) ** 2
            _add_residual(1.0, 0.0, dx, 0.0, lx, ly, v, np.inf, to_H, to_g)
            _add_residual(0.0, 1.0, 0.0, dy, lx, ly, v, np.inf, to_H, to_g)
    _mirror(H_new)
    _free_shift(H_new, g_new)
    H += H_new
    g += g_new
    _mirror(H)
    return inliers


@compiled_on_views
def _is_alone(facets: FloatArray, f: int) -> bool:
    """Return True for a cluster, and for a segment of one facet: as small as a leg."""
    return bool(facets[f, LINKED] == 0.0 and (f + 1 == len(facets) or facets[f + 1, LINKED] == 0.0))


@compiled_on_views
def _mirror(H: FloatArray) -> None:
    """Fill the lower triangle of a symmetric (3, 3) from the upper."""
    H[1, 0], H[2, 0], H[2, 1] = H[0, 1], H[0, 2], H[1, 2]


@compiled
def _free_shift(H: FloatArray, g: FloatArray) -> None:
    """Allow an unknown common shift (dx, dy) of everything in H (3, 3) and g (3,), and eliminate it.

    That leaves the Schur complements H - U S U^T and g - U S g_xy, with U the first two columns of H and
    S = (H_xy + I / SHIFT_SIGMA^2)^-1: all facets together have at most the information of one measurement with
    SHIFT_SIGMA.
    """
    if H[0, 0] + H[1, 1] == 0.0:
        return
    p, q, r = H[0, 0] + SHIFT_SIGMA**-2, H[0, 1], H[1, 1] + SHIFT_SIGMA**-2
    determinant = p * r - q * q
    sxx, sxy, syy = r / determinant, -q / determinant, p / determinant
    u, gx, gy = H.copy(), g[0], g[1]
    for i in range(3):
        x, y = u[i, 0] * sxx + u[i, 1] * sxy, u[i, 0] * sxy + u[i, 1] * syy
        g[i] -= x * gx + y * gy
        for j in range(3):
            H[i, j] -= x * u[j, 0] + y * u[j, 1]


@compiled_on_views
def _add_residual(
    nx: float, ny: float, dx: float, dy: float, lx: float, ly: float, v: float, kernel: float, H: FloatArray,
    g: FloatArray,
) -> float:  # fmt: skip
    """Add one residual along a normal, at the lever (lx, ly) from the sensor; return its robust weight."""
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


@compiled_on_views
def _nearest(x: float, y: float, nx: float, ny: float, grid: Grid, gate: float, wide: bool) -> int:
    """Return the surfel for a facet, -1 for none, from the four nearest cells, or from nine if ``wide``."""
    u, v = x / grid.cell, y / grid.cell
    row, column = int(np.floor(v)), int(np.floor(u))
    low_row = row - 1 if wide or v - row < 0.5 else row
    low_column = column - 1 if wide or u - column < 0.5 else column
    span = 3 if wide else 2
    low_row, low_column = low_row - grid.corner[0], low_column - grid.corner[1]
    surfels, (rows, columns) = grid.surfels, grid.head.shape
    wall = nx != 0.0 or ny != 0.0
    best, least = -1, np.inf
    for i in range(max(low_row, 0), min(low_row + span, rows)):
        for j in range(max(low_column, 0), min(low_column + span, columns)):
            k = grid.head[i, j]
            while k >= 0:
                snx, sny = surfels[k, NX], surfels[k, NY]
                if wall == (snx != 0.0 or sny != 0.0):
                    dx, dy = x - surfels[k, X], y - surfels[k, Y]
                    across = abs(dx * snx + dy * sny) if wall else np.sqrt(dx * dx + dy * dy)
                    cost = across * across + ALONG_WEIGHT * (dx * dx + dy * dy)
                    if across < gate and cost < least and (not wall or nx * snx + ny * sny > PAIR_COSINE):
                        best, least = k, cost
                k = grid.next[k]
    return best
