"""Puts facets of a scan into the grid of surfels, compiled."""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.lines.facets import LINKED, VARIANCE
from slam.mapping.surfel_grid import ALIVE, AXIS, BORN, FREE, HITS, INFORMATION, MISSES, NX, NY, TAKEN, Grid, X, Y
from slam.pose import FloatArray

JOIN_COSINE = 0.8  # least cosine between the normals of a surfel and of a facet that joins it
GAP_INFORMATION = 0.25  # ratio of the information of an interpolated wall piece to that of an observed one
NOISE_MISS = 0.1  # misses of an uncertain surfel when something else was seen in its cell


@compiled
def put(grid: Grid, facets: FloatArray, pose: FloatArray, gate: float, max_hits: float, pose_sigma: float) -> None:
    """Add facets (F, 7), sensor frame, seen from ``pose`` (3,); the grid must have room for them.

    A wall continues between the facets of one segment, however far apart the beams were.
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    last_x = last_y = 0.0
    for f in range(len(facets)):
        fx, fy, fnx, fny = facets[f, X], facets[f, Y], facets[f, NX], facets[f, NY]
        x, y = pose[0] + c * fx - s * fy, pose[1] + s * fx + c * fy
        nx, ny = c * fnx - s * fny, s * fnx + c * fny
        information = 1.0 / (facets[f, VARIANCE] + pose_sigma * pose_sigma)
        steps = int(np.hypot(x - last_x, y - last_y) / grid.cell + 0.5) if facets[f, LINKED] > 0.0 else 0
        for i in range(1, steps):
            t = i / steps
            between_x, between_y = last_x + t * (x - last_x), last_y + t * (y - last_y)
            _put_one(grid, between_x, between_y, nx, ny, GAP_INFORMATION * information, gate, max_hits)
        _put_one(grid, x, y, nx, ny, information, gate, max_hits)
        last_x, last_y = x, y


@compiled
def _put_one(
    grid: Grid, x: float, y: float, nx: float, ny: float, information: float, gate: float, max_hits: float
) -> None:
    """Merge a point with normal into the nearest surfel of its cell with a similar normal, or add one."""
    row, column = int(np.floor(y / grid.cell)) - grid.corner[0], int(np.floor(x / grid.cell)) - grid.corner[1]
    first = grid.head[row, column]
    nearest = _nearest(grid, first, x, y, nx, ny, gate)
    if nearest >= 0:
        _count_noise(grid, first, nearest, nx, ny, max_hits)
        _merge(grid.surfels, nearest, x, y, nx, ny, information, max_hits)
        return
    k, s = _take_row(grid), grid.surfels
    s[k, X], s[k, Y], s[k, NX], s[k, NY] = x, y, nx, ny
    s[k, INFORMATION], s[k, HITS], s[k, MISSES], s[k, BORN] = information, 1.0, 0.0, grid.path_length
    grid.evidence[k] = 0
    grid.evidence[k, AXIS] = abs(nx) > abs(ny)
    grid.next[k] = first
    grid.head[row, column] = k


@compiled_on_views
def _nearest(grid: Grid, first: int, x: float, y: float, nx: float, ny: float, gate: float) -> int:
    """Return the nearest surfel of a cell's list, nearer than ``gate`` and facing this way, -1 for none."""
    wall = nx != 0.0 or ny != 0.0
    best, nearest = -1, gate
    k, s = first, grid.surfels
    while k >= 0:
        snx, sny = s[k, NX], s[k, NY]
        if wall == (snx != 0.0 or sny != 0.0):
            dx, dy = x - s[k, X], y - s[k, Y]
            distance = abs(dx * snx + dy * sny) if wall else np.hypot(dx, dy)
            if distance < nearest and (not wall or nx * snx + ny * sny > JOIN_COSINE):
                best, nearest = k, distance
        k = grid.next[k]
    return best


@compiled
def _take_row(grid: Grid) -> int:
    """Return a row of ``surfels`` for a new one: the first free row, or a new row."""
    k = grid.counts[FREE]
    if k >= 0:
        grid.counts[FREE] = grid.next[k]
    else:
        k = grid.counts[TAKEN]
        grid.counts[TAKEN] += 1
    grid.counts[ALIVE] += 1
    return int(k)


@compiled_on_views
def _count_noise(grid: Grid, first: int, seen: int, nx: float, ny: float, max_hits: float) -> None:
    """Add NOISE_MISS to each other uncertain surfel of the cell that faces the same side as the observed one, ``seen``.

    One that is hit less than a tenth as often as its neighbour is noise. Otherwise noise would accumulate along every
    wall during a long run.
    """
    k, s = first, grid.surfels
    while k >= 0:
        if k != seen and s[k, HITS] < max_hits and nx * s[k, NX] + ny * s[k, NY] >= 0.0:
            s[k, MISSES] += NOISE_MISS
        k = grid.next[k]


@compiled_on_views
def _merge(
    s: FloatArray, k: int, x: float, y: float, nx: float, ny: float, information: float, max_hits: float
) -> None:
    """Merge an observation into the surfel ``k`` by weighted means; a surfel with many hits is fixed."""
    s[k, MISSES] = max(0.0, s[k, MISSES] - 1.0)
    if s[k, HITS] >= max_hits:
        return
    share = information / (s[k, INFORMATION] + information)
    s[k, X] += share * (x - s[k, X])
    s[k, Y] += share * (y - s[k, Y])
    if nx != 0.0 or ny != 0.0:
        mx, my = s[k, NX] + share * (nx - s[k, NX]), s[k, NY] + share * (ny - s[k, NY])
        norm = np.sqrt(mx * mx + my * my)
        s[k, NX], s[k, NY] = mx / norm, my / norm
    s[k, INFORMATION] += information
    s[k, HITS] += 1.0
