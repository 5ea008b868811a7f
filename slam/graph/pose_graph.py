"""The pose graph: nodes in the plane, measured edges between them, and the poses that fit them best.

The residual of an edge is that of Olson and of g2o's SE2: e = T_first_second^-1 (estimated) minus the measured one, in
the axes of the first node. Edges of loops are robust, with the kernel of Geman and McClure, w = (c / (c + chi^2))^2,
which starts as wide as the worst edge needs and shrinks to c (graduated non-convexity, Yang et al., RA-L 2020): so a
wrong loop among correct ones loses its weight for any start.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views, wrapped
from slam.lines.segments import IntArray
from slam.pose import FloatArray, wrap_angles
from slam.small_matrices import product, times

if TYPE_CHECKING:  # scipy loads slowly, and only the solver needs it
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import SuperLU

NO_LOOP: Final = -1
"""Loop number of an edge that belongs to no loop."""
BREAK: Final = -2
"""Loop number of an edge over a break of the front end: the scan after it did not fit those before, so that the edge
has only odometry. It has a robust kernel, as the edges of loops have."""
SHRINK: Final = 3.0
"""Factor by which the kernel shrinks from one iteration to the next."""
MAX_ITERATIONS: Final = 40


class Edge(NamedTuple):
    """Measured pose of one node relative to another."""

    first: int
    second: int
    measured: FloatArray
    """T_first_second (3,)."""
    information: FloatArray
    """(3, 3): information, in the axes of the first node."""
    loop: int = NO_LOOP
    """Number of the loop that it belongs to."""


class Edges(NamedTuple):
    """E edges as arrays."""

    first: IntArray
    """(E,): indices of the nodes."""
    second: IntArray
    measured: FloatArray
    """(E, 3): T_first_second."""
    information: FloatArray
    """(E, 3, 3): information, in the axes of the first node."""
    loop: IntArray
    """(E,): loop number of each edge, NO_LOOP for none; edges of loops are robust."""

    @classmethod
    def of(cls, edges: Iterable[Edge]) -> Self:
        """Stack these edges."""
        rows = list(edges)
        return cls(
            np.array([edge.first for edge in rows], np.int64),
            np.array([edge.second for edge in rows], np.int64),
            np.array([edge.measured for edge in rows], np.float64).reshape(-1, 3),
            np.array([edge.information for edge in rows], np.float64).reshape(-1, 3, 3),
            np.array([edge.loop for edge in rows], np.int64),
        )

    @property
    def robust(self) -> NDArray[np.bool_]:
        """True for the edges of loops and over breaks, (E,)."""
        return np.asarray(self.loop != NO_LOOP)

    def settled(self, weights: FloatArray) -> tuple[Self, FloatArray]:
        """Return the edges and their weights (E,) once the weights of edges over breaks are final.

        Edges over breaks become ordinary ones: their information is multiplied by their weight.
        """
        breaks = self.loop == BREAK
        information = self.information * np.where(breaks, weights, 1.0)[:, None, None]
        edges = self._replace(information=information, loop=np.where(breaks, NO_LOOP, self.loop))
        return edges, np.where(breaks, 1.0, weights)


class Solution(NamedTuple):
    """Poses that fit the edges best."""

    poses: FloatArray
    """(N, 3): poses of the nodes."""
    weights: FloatArray
    """(E,): weight of each edge, 1 for those of no loop, else 0 to 1."""
    iterations: int


def solve_graph(poses: FloatArray, edges: Edges, kernel: float, tolerance: float = 1e-5) -> Solution:
    """Solve by Gauss-Newton from these poses (N, 3); the first is fixed.

    ``kernel`` is the scale of the loops' chi^2. The iteration ends at a step below ``tolerance``, metres and radians.
    """
    poses, robust = poses.copy(), edges.robust
    chi_squared = squared_errors(poses, edges)
    width = max(kernel, float(chi_squared[robust].max(initial=0.0)))
    iterations, step = 0, np.inf
    while iterations < MAX_ITERATIONS and (width > kernel or step >= tolerance):
        width = kernel if iterations == 0 and width <= kernel else max(kernel, width / SHRINK)
        weights = robust_weights(chi_squared, robust, width)
        H, g = linear_system(poses, edges, weights)
        moved = -factorize(H[3:, 3:]).solve(g[3:]).reshape(-1, 3)
        poses[1:] += moved
        poses[:, 2] = wrap_angles(poses[:, 2])
        step, iterations = float(np.abs(moved).max(initial=0.0)), iterations + 1
        chi_squared = squared_errors(poses, edges)
    return Solution(poses, robust_weights(chi_squared, robust, kernel), iterations)


def robust_weights(chi_squared: FloatArray, robust: NDArray[np.bool_], kernel: float) -> FloatArray:
    """Return the weight of every edge (E,): that of Geman and McClure for the robust ones, else 1."""
    return np.where(robust, (kernel / (kernel + chi_squared)) ** 2, 1.0)


def linear_system(poses: FloatArray, edges: Edges, weights: FloatArray) -> tuple["csc_matrix", FloatArray]:
    """Return the information matrix (3N, 3N) and the gradient (3N,) of half the weighted sum of squares."""
    from scipy.sparse import csc_matrix

    size = 3 * len(poses)
    rows, columns, values, gradient = _normal_equations(
        poses, edges.first, edges.second, edges.measured, edges.information, weights
    )
    return csc_matrix((values, (rows, columns)), shape=(size, size)), gradient


def factorize(H: "csc_matrix") -> "SuperLU":
    """Factorise a symmetric positive definite matrix."""
    from scipy.sparse.linalg import splu

    options = {"SymmetricMode": True}
    return splu(H, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)


def squared_errors(poses: FloatArray, edges: Edges) -> FloatArray:
    """Return chi^2 of every edge (E,)."""
    return _squared_errors(poses, edges.first, edges.second, edges.measured, edges.information)


@compiled_on_views
def _residual(first: FloatArray, second: FloatArray, measured: FloatArray, e: FloatArray) -> tuple[float, float]:
    """Write the residual (3,) of an edge; return the second node's position in the axes of the first."""
    c, s = np.cos(first[2]), np.sin(first[2])
    dx, dy = second[0] - first[0], second[1] - first[1]
    x, y = c * dx + s * dy, c * dy - s * dx
    e[0], e[1], e[2] = x - measured[0], y - measured[1], wrapped(second[2] - first[2] - measured[2])
    return x, y


@compiled
def _squared_errors(
    poses: FloatArray, first: IntArray, second: IntArray, measured: FloatArray, information: FloatArray
) -> FloatArray:
    errors, e = np.empty(len(first)), np.empty(3)
    for k in range(len(first)):
        _residual(poses[first[k]], poses[second[k]], measured[k], e)
        total = 0.0
        for i in range(3):
            for j in range(3):
                total += e[i] * information[k, i, j] * e[j]
        errors[k] = total
    return errors


@compiled
def _normal_equations(
    poses: FloatArray, first: IntArray, second: IntArray, measured: FloatArray, information: FloatArray,
    weights: FloatArray,
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:  # fmt: skip
    """Return rows, columns, values (36 E,) of the information matrix, and the gradient (3N,).

    Values with equal row and column add up.
    """
    count = len(first)
    rows, columns = np.empty(36 * count, np.int64), np.empty(36 * count, np.int64)
    values, gradient = np.empty(36 * count), np.zeros(3 * len(poses))
    e, J, at = np.empty(3), np.zeros((3, 6)), np.empty(6, np.int64)
    for k in range(count):
        x, y = _residual(poses[first[k]], poses[second[k]], measured[k], e)
        _fill_jacobian(poses[first[k], 2], x, y, J)
        JtW = product(J.T, information[k])
        block, force = product(JtW, J), times(JtW, e)
        for i in range(3):
            at[i], at[3 + i] = 3 * first[k] + i, 3 * second[k] + i
        for i in range(6):
            gradient[at[i]] += weights[k] * force[i]
            for j in range(6):
                n = 36 * k + 6 * i + j
                rows[n], columns[n], values[n] = at[i], at[j], weights[k] * block[i, j]
    return rows, columns, values, gradient


@compiled_on_views
def _fill_jacobian(heading: float, x: float, y: float, J: FloatArray) -> None:
    """Write the derivatives (3, 6) of a residual by the poses of its two nodes into J.

    (x, y) is the position of the second node in the frame of the first.
    """
    c, s = np.cos(heading), np.sin(heading)
    J[0, 0], J[0, 1], J[0, 2] = -c, -s, y
    J[1, 0], J[1, 1], J[1, 2] = s, -c, -x
    J[2, 2] = -1.0
    J[0, 3], J[0, 4] = c, s
    J[1, 3], J[1, 4] = -s, c
    J[2, 5] = 1.0
