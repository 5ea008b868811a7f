"""Normal equations of wall observations (facets matched to walls), reduced to the poses by eliminating the walls.

Facet f of scan k that sees wall m gives the residual r = n_m . (R_k f + t_k - c_m) - o_m, with the normal n_m turned by
d_m: a wall has an offset o and a turn d, estimated once for all scans that see it. (R_k, t_k) is the pose of scan k,
and c_m a point on wall m. The weight is that of Geman and McClure, 1 / (v (1 + r^2 / (kernel^2 + v))^2), with the
variance v of the facet along its normal. A wall near a main direction of the building also has a soft constraint to
it, whose weight depends on how closely the walls follow the main directions (see ``slam.graph.main_edges``); the main
direction itself is free.

Eliminating the walls gives S = A - B D^-1 B^T for the poses: A has a block for each pose, D one for each wall, and B
one for each pair of a wall and a scan that sees it. S is full if many scans see one wall, and is never formed:
``apply`` multiplies by it.
"""

from typing import NamedTuple

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.graph.main_edges import MainEdges
from slam.graph.wall_landmarks import LINE_NX, LINE_NY, LINE_X, LINE_Y, FoundWalls, PlacedFacets
from slam.lines.segments import IntArray
from slam.pose import FloatArray

FIT_ROUNDS = 2  # rounds of reweighting the line of a wall
MIN_SCATTER = 0.01  # metres along a wall, one standard deviation: below it, no direction is known


class WallEquations(NamedTuple):
    """S and its right hand side; pairs are sorted by wall, and within a wall by scan."""

    begins: IntArray
    """(M + 1,): first pair of each wall, and the number of pairs."""
    nodes: IntArray
    """(P,): node of each pair's scan."""
    coupling: FloatArray
    """(P, 3, 2): blocks of B."""
    blocks: FloatArray
    """(N, 3, 3): A."""
    covariance: FloatArray
    """(M, 2, 2): inverse blocks of D, of offset and turn of each wall given the poses."""
    gradient: FloatArray
    """(N, 3): gradient of half the weighted sum of squares, the walls eliminated."""
    main: MainEdges
    slack: FloatArray
    """(K,): information of each main direction, its walls eliminated."""
    squares: FloatArray
    """(M, 2): for each wall, the sum of w r^2 (dimensionless), and the sum of the weights w, m^-2."""

    def apply(self, poses: FloatArray) -> FloatArray:
        """Return S times a vector (N, 3)."""
        forces = _forces(self.begins, self.nodes, self.coupling, poses)
        turned = _eliminated(forces, self.covariance, self.main, self.slack)
        return _reaction(self.begins, self.nodes, self.coupling, self.blocks, turned, poses)


def fit_lines(placed: PlacedFacets, walls: FoundWalls, kernel: float) -> FloatArray:
    """Return the lines (M, 4) that fit the facets of the walls best, at the present poses."""
    lines = walls.lines.copy()
    _fit_lines(placed, walls.facets, walls.begins, kernel, lines)
    return lines


def wall_equations(
    placed: PlacedFacets, nodes: IntArray, walls: FoundWalls, main: MainEdges, kernel: float, count: int
) -> WallEquations:
    """Return the normal equations at the present poses and lines, for ``count`` nodes.

    ``nodes`` (K,) are those of the scans.
    """
    begins = _pair_begins(placed.scans, walls.facets, walls.begins)
    seen_by, coupling, blocks, gradient, D, forces, squares = _linearized(placed, nodes, walls, kernel, begins, count)
    D[:, 1, 1] += MIN_SCATTER**2 * D[:, 0, 0] + main.information
    forces[:, 1] += main.information * main.error
    covariance = np.asarray(np.linalg.inv(D), np.float64)
    slack = _slack(main, covariance)
    turned = _eliminated(forces, covariance, main, slack)
    gradient += _reaction(begins, seen_by, coupling, np.zeros_like(blocks), turned, gradient)
    return WallEquations(begins, seen_by, coupling, blocks, covariance, gradient, main, slack, squares)


def _slack(main: MainEdges, covariance: FloatArray) -> FloatArray:
    """Return the information of each main direction (K,), its walls eliminated."""
    held = main.direction >= 0
    left = main.information - main.information**2 * covariance[:, 1, 1]
    return np.asarray(np.bincount(main.direction[held], left[held]), np.float64)


@compiled_on_views
def _fit_lines(placed: PlacedFacets, numbers: IntArray, begins: IntArray, kernel: float, lines: FloatArray) -> None:
    for m in range(len(lines)):
        for _ in range(FIT_ROUNDS):
            nx, ny, cx, cy = lines[m]
            w0 = ws = wss = wr = wrs = 0.0
            for i in range(begins[m], begins[m + 1]):
                f = numbers[i]
                dx, dy = placed.points[f, 0] - cx, placed.points[f, 1] - cy
                r, s = nx * dx + ny * dy, nx * dy - ny * dx
                w = _weight(r, placed.variances[f], kernel)
                w0, ws, wss = w0 + w, ws + w * s, wss + w * s * s
                wr, wrs = wr + w * r, wrs + w * r * s
            mean_s, mean_r = ws / w0, wr / w0
            turn = -(wrs - mean_r * ws) / (wss - mean_s * ws + MIN_SCATTER**2 * w0)
            lines[m, LINE_X] = cx + mean_r * nx - mean_s * ny
            lines[m, LINE_Y] = cy + mean_r * ny + mean_s * nx
            c, s = np.cos(turn), np.sin(turn)
            lines[m, LINE_NX], lines[m, LINE_NY] = c * nx - s * ny, s * nx + c * ny


@compiled_on_views
def _weight(r: float, variance: float, kernel: float) -> float:
    t = 1.0 + r * r / (kernel * kernel + variance)
    return 1.0 / (variance * t * t)


@compiled
def _pair_begins(scans: IntArray, numbers: IntArray, begins: IntArray) -> IntArray:
    """Return the first pair of each wall, and the number of pairs, (M + 1,)."""
    pairs = np.zeros(len(begins), np.int64)
    for m in range(len(begins) - 1):
        count = 0
        for i in range(begins[m], begins[m + 1]):
            if i == begins[m] or scans[numbers[i]] != scans[numbers[i - 1]]:
                count += 1
        pairs[m + 1] = pairs[m] + count
    return pairs


@compiled
def _linearized(
    placed: PlacedFacets, nodes: IntArray, walls: FoundWalls, kernel: float, begins: IntArray, count: int
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the nodes of the pairs and the linearised equations of pairs and walls.

    These are B, A, the gradient w.r.t. the poses (N, 3), D, the gradient w.r.t. the walls (M, 2), and squares (M, 2).
    """
    seen_by, coupling = np.empty(begins[-1], np.int64), np.zeros((begins[-1], 3, 2))
    blocks, gradient = np.zeros((count, 3, 3)), np.zeros((count, 3))
    size = len(walls.lines)
    D, forces, squares = np.zeros((size, 2, 2)), np.zeros((size, 2)), np.zeros((size, 2))
    J = np.empty(3)
    for m in range(len(walls.lines)):
        nx, ny, cx, cy = walls.lines[m]
        p, last = begins[m] - 1, -1
        for i in range(walls.begins[m], walls.begins[m + 1]):
            f = walls.facets[i]
            if placed.scans[f] != last:
                p, last = p + 1, placed.scans[f]
                seen_by[p] = nodes[last]
            k = seen_by[p]
            dx, dy = placed.points[f, 0] - cx, placed.points[f, 1] - cy
            r, s = nx * dx + ny * dy, nx * dy - ny * dx
            w = _weight(r, placed.variances[f], kernel)
            J[0], J[1], J[2] = nx, ny, placed.levers[f, 0] * ny - placed.levers[f, 1] * nx
            for a in range(3):
                for b in range(3):
                    blocks[k, a, b] += w * J[a] * J[b]
                coupling[p, a, 0] -= w * J[a]
                coupling[p, a, 1] += w * J[a] * s
                gradient[k, a] += w * J[a] * r
            D[m, 0, 0] += w
            D[m, 0, 1] -= w * s
            D[m, 1, 0] -= w * s
            D[m, 1, 1] += w * s * s
            forces[m, 0] -= w * r
            forces[m, 1] += w * r * s
            squares[m, 0] += w * r * r
            squares[m, 1] += w
    return seen_by, coupling, blocks, gradient, D, forces, squares


@compiled
def _forces(begins: IntArray, nodes: IntArray, coupling: FloatArray, poses: FloatArray) -> FloatArray:
    """Return B^T times a vector (N, 3): (M, 2)."""
    forces = np.zeros((len(begins) - 1, 2))
    for m in range(len(forces)):
        for p in range(begins[m], begins[m + 1]):
            for a in range(3):
                forces[m, 0] += coupling[p, a, 0] * poses[nodes[p], a]
                forces[m, 1] += coupling[p, a, 1] * poses[nodes[p], a]
    return forces


@compiled
def _eliminated(forces: FloatArray, covariance: FloatArray, main: MainEdges, slack: FloatArray) -> FloatArray:
    """Return D^-1 times the forces (M, 2); main directions are eliminated from D by Sherman and Morrison."""
    turned, pull = np.empty_like(forces), np.zeros(len(slack))
    for m in range(len(forces)):
        C = covariance[m]
        turned[m, 0] = C[0, 0] * forces[m, 0] + C[0, 1] * forces[m, 1]
        turned[m, 1] = C[1, 0] * forces[m, 0] + C[1, 1] * forces[m, 1]
        if main.direction[m] >= 0:
            pull[main.direction[m]] += main.information[m] * turned[m, 1]
    for m in range(len(forces)):
        k = main.direction[m]
        if k >= 0:
            share = main.information[m] * pull[k] / slack[k]
            turned[m, 0] += covariance[m, 0, 1] * share
            turned[m, 1] += covariance[m, 1, 1] * share
    return turned


@compiled
def _reaction(
    begins: IntArray, nodes: IntArray, coupling: FloatArray, blocks: FloatArray, turned: FloatArray, poses: FloatArray
) -> FloatArray:
    """Return A times a vector (N, 3), minus B times the walls (M, 2)."""
    out = np.empty_like(poses)
    for k in range(len(poses)):
        for a in range(3):
            out[k, a] = blocks[k, a, 0] * poses[k, 0] + blocks[k, a, 1] * poses[k, 1] + blocks[k, a, 2] * poses[k, 2]
    for m in range(len(turned)):
        for p in range(begins[m], begins[m + 1]):
            for a in range(3):
                out[nodes[p], a] -= coupling[p, a, 0] * turned[m, 0] + coupling[p, a, 1] * turned[m, 1]
    return out
