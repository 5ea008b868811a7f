"""Joint refinement, the last step of the graph: all key scans and all walls of a building by least squares at once.

Each round finds the walls that the facets see at the present poses, and moves the poses by Gauss-Newton. The walls are
eliminated; the remaining system of the poses is solved by conjugate gradients, with the factors of the graph itself as
preconditioner. From round to round the kernel shrinks, and with it the tolerances for the facets of a wall. All
computations are in the frame of the first node, so that the result does not depend on the map's position.
"""

from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from slam.graph.main_edges import find_main_edges, no_main_edges
from slam.graph.pose_graph import Edges, factorize, linear_system
from slam.graph.refined_walls import RefinedWalls, refined_walls
from slam.graph.wall_equations import WallEquations, fit_lines, wall_equations
from slam.graph.wall_landmarks import LINE_NX, LINE_NY, LINE_X, LINE_Y, FoundWalls, PlacedFacets, find_walls, wall_spans
from slam.lines.facets import NX, NY, VARIANCE, X, Y
from slam.lines.segments import IntArray
from slam.pose import FloatArray, compose_poses, relative_poses, wrap_angles

if TYPE_CHECKING:  # scipy loads slowly
    from scipy.sparse import csr_matrix
    from scipy.sparse.linalg import SuperLU


class RefinementSettings(NamedTuple):
    """Settings of the refinement, SI units."""

    floor: float = 0.01
    """Standard deviation added to every facet, metres: real walls are not perfectly flat."""
    correlation: float = 4.0
    """Errors of neighbouring facets are correlated: their information is divided by this."""
    kernel: float = 0.05
    """Residuals far above this, metres, lose their weight."""
    straight: float = 0.01
    """Largest distance of a piece of a wall from the wall's line, metres."""
    gap: float = 0.04
    """Largest distance across a wall between neighbouring facets of one piece, metres."""
    first_width: float = 4.0
    """Factor of kernel, ``straight`` and ``gap`` in the first round; it is halved until it is 1."""
    reused: float = 0.03
    """Weight of the edges from matching, as the facets contain the same information about the walls."""
    directions: bool = True
    """True to attach walls softly to the main directions of the building, if it has any."""
    rounds: int = 6
    """Largest number of rounds."""
    settled: float = 2e-3
    """The refinement ends when the poses move by less than this, root mean square, metres."""
    tolerance: float = 1e-2
    """Relative tolerance of the conjugate gradients."""
    max_iterations: int = 150
    """Largest number of iterations of the conjugate gradients."""


class Refinement(NamedTuple):
    """Refined poses and walls."""

    poses: FloatArray
    """(N, 3): refined poses of the nodes."""
    walls: RefinedWalls
    rounds: int


def refine(
    poses: FloatArray, edges: Edges, weights: FloatArray, facets: list[FloatArray], nodes: IntArray,
    settings: RefinementSettings | None = None,
) -> Refinement:  # fmt: skip
    """Refine poses (N, 3) by edges with these weights (E,) and by the walls that are seen; the first pose is fixed.

    ``facets`` (F_k, 7) are those of the K key scans, sensor frame; ``nodes`` (K,) are the indices of their nodes, whose
    poses are the sensor's.
    """
    settings = settings or RefinementSettings()
    origin = poses[0] if len(poses) else np.zeros(3)
    local, sensed = relative_poses(origin, poses), _Sensed.of(facets, settings)
    preconditioner = factorize(linear_system(local, edges, weights)[0][3:, 3:]) if len(poses) > 1 else None
    weights = _beside_walls(edges, weights, nodes, len(poses), settings.reused)
    width, step, rounds = settings.first_width, np.inf, 0
    while preconditioner is not None and rounds < settings.rounds and step > settings.settled:
        equations = _equations(sensed.seen_from(local[nodes]), nodes, width, len(poses), settings)[1]
        H, gradient = linear_system(local, edges, weights)
        gradient = gradient.reshape(-1, 3) + equations.gradient
        moved = _conjugate_gradients(H.tocsr(), equations, preconditioner, -gradient, settings)
        local += moved
        local[:, 2] = wrap_angles(local[:, 2])
        step = float(np.sqrt(np.mean(moved[:, :2] ** 2))) if width <= 1.0 else np.inf
        width, rounds = max(0.5 * width, 1.0), rounds + 1
    placed = sensed.seen_from(local[nodes])
    walls, equations = _equations(placed, nodes, 1.0, len(poses), settings)
    return Refinement(compose_poses(origin, local), refined_walls(placed, walls, equations, origin), rounds)


class _Sensed(NamedTuple):
    """The facets of all key scans, without those that have no normal."""

    facets: FloatArray
    """(F, 7): facets, sensor frame."""
    variances: FloatArray
    """(F,): variance along the normal, increased by ``floor`` and ``correlation``."""
    scans: IntArray
    """(F,): index of the key scan."""

    @classmethod
    def of(cls, facets: list[FloatArray], settings: RefinementSettings) -> Self:
        together = np.concatenate([np.empty((0, 7)), *facets])
        scans = np.repeat(np.arange(len(facets)), np.array([len(one) for one in facets], np.int64))
        walls = (together[:, NX] != 0.0) | (together[:, NY] != 0.0)
        variances = settings.correlation * (together[walls, VARIANCE] + settings.floor**2)
        return cls(together[walls], variances, scans[walls])

    def seen_from(self, poses: FloatArray) -> PlacedFacets:
        """Return the facets, transformed by the sensor's poses (K, 3)."""
        c, s = np.cos(poses[:, 2])[self.scans], np.sin(poses[:, 2])[self.scans]
        x, y, nx, ny = self.facets[:, [X, Y, NX, NY]].T
        levers = np.column_stack([c * x - s * y, s * x + c * y])
        normals = np.column_stack([c * nx - s * ny, s * nx + c * ny])
        return PlacedFacets(poses[self.scans, :2] + levers, normals, levers, self.variances, self.scans)


def _beside_walls(edges: Edges, weights: FloatArray, nodes: IntArray, count: int, reused: float) -> FloatArray:
    """Return the weights (E,) that the edges have when the walls are added: lower, except for odometry's edges."""
    is_key = np.zeros(count, np.bool_)
    is_key[nodes] = True
    odometry = is_key[edges.first] & is_key[edges.second] & ~edges.robust
    return np.where(odometry, weights, reused * weights)


def _equations(
    placed: PlacedFacets, nodes: IntArray, width: float, count: int, settings: RefinementSettings
) -> tuple[FoundWalls, WallEquations]:
    """Find the walls, and their equations for ``count`` poses."""
    kernel = width * settings.kernel
    walls = find_walls(placed, width * settings.straight, width * settings.gap)
    walls = walls._replace(lines=fit_lines(placed, walls, kernel))
    main = no_main_edges(len(walls.lines))
    if settings.directions:
        spans = wall_spans(placed.points, walls.lines, walls.facets, walls.begins)
        theta = np.arctan2(walls.lines[:, LINE_NY], walls.lines[:, LINE_NX])
        places = walls.lines[:, LINE_X : LINE_Y + 1]
        main = find_main_edges(theta, spans[:, 1] - spans[:, 0], places)
    return walls, wall_equations(placed, nodes, walls, main, kernel, count)


def _conjugate_gradients(
    H: "csr_matrix",
    equations: WallEquations,
    preconditioner: "SuperLU",
    right: FloatArray,
    settings: RefinementSettings,
) -> FloatArray:
    """Solve (H + S) x = ``right`` (N, 3) with the first node fixed; S are the equations of the walls."""
    x, residual = np.zeros_like(right), right.copy()
    residual[0] = 0.0
    direction, before, least = np.zeros_like(right), np.inf, 0.0
    for iteration in range(settings.max_iterations):
        preconditioned = np.zeros_like(right)
        preconditioned[1:] = preconditioner.solve(residual[1:].ravel()).reshape(-1, 3)
        squared = float(np.sum(residual * preconditioned))
        least = settings.tolerance**2 * squared if iteration == 0 else least
        if squared <= least:
            break
        direction = preconditioned + squared / before * direction
        image = (H @ direction.ravel()).reshape(-1, 3) + equations.apply(direction)
        image[0] = 0.0
        length, before = squared / float(np.sum(direction * image)), squared
        x += length * direction
        residual -= length * image
    return x
