"""The walls of a building after the refinement, with their uncertainty."""

from typing import NamedTuple

import numpy as np

from slam.graph.wall_equations import WallEquations
from slam.graph.wall_landmarks import FoundWalls, PlacedFacets, wall_spans
from slam.lines.segments import IntArray
from slam.pose import FloatArray


class RefinedWalls(NamedTuple):
    """M walls, map frame."""

    ends: FloatArray
    """(M, 2, 2): [wall, start or end, x or y], metres, with the sensor to the left. A wall reaches from the first to
    the last of its facets; there may be doors between."""
    covariance: FloatArray
    """(M, 2, 2): covariance of a wall's offset at its middle and of its direction, given the poses; m^2, m rad,
    rad^2."""
    rms: FloatArray
    """(M,): weighted root mean square of the residuals, metres."""
    scans: IntArray
    """(M,): number of key scans that see the wall."""
    anchor: IntArray
    """(M,): node of the key scan with the most information about it."""


def refined_walls(
    placed: PlacedFacets, walls: FoundWalls, equations: WallEquations, T_map_local: FloatArray
) -> RefinedWalls:
    """Return the refined walls in the map; all arguments are in the frame ``local``, whose pose is ``T_map_local``."""
    spans = wall_spans(placed.points, walls.lines, walls.facets, walls.begins)
    nx, ny, x, y = walls.lines.T
    ends = np.column_stack([x, y])[:, None] + spans[:, :, None] * np.column_stack([-ny, nx])[:, None]
    J = np.tile(np.eye(2), (len(spans), 1, 1))
    J[:, 0, 1] = -spans.mean(axis=1)  # the normal turns, and with it the offset at the middle
    covariance = J @ equations.covariance @ J.swapaxes(1, 2)
    c, s = np.cos(T_map_local[2]), np.sin(T_map_local[2])
    ends = ends @ np.array([[c, s], [-s, c]]) + T_map_local[:2]
    rms = np.sqrt(equations.squares[:, 0] / equations.squares[:, 1])
    return RefinedWalls(ends, covariance, rms, np.diff(equations.begins), _anchors(equations))


def wall_covariances(walls: RefinedWalls, poses: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return the covariances (M, 2, 2) of the walls' offsets and directions in the map frame.

    The poses (N, 3) have the covariances (N, 3, 3).

    The covariance of a wall is that of its anchor's pose, plus its own for known poses. Their correlation, by other
    scans that see the wall, is ignored: the result is rather too large.
    """
    along = walls.ends[:, 1] - walls.ends[:, 0]
    tx, ty = (along / np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-12)[:, None]).T
    nx, ny = ty, -tx
    lx, ly = (walls.ends.mean(axis=1) - poses[walls.anchor, :2]).T
    J = np.zeros((len(along), 2, 3))
    J[:, 0, 0], J[:, 0, 1], J[:, 0, 2], J[:, 1, 2] = nx, ny, lx * ny - ly * nx, 1.0
    return np.asarray(walls.covariance + J @ covariances[walls.anchor] @ J.swapaxes(1, 2))


def _anchors(equations: WallEquations) -> IntArray:
    """Return the node of the scan that has the most weight in each wall, (M,)."""
    weight = np.hypot(equations.coupling[:, 0, 0], equations.coupling[:, 1, 0])
    wall = np.repeat(np.arange(len(equations.begins) - 1), np.diff(equations.begins))
    best_first = np.lexsort((-weight, wall))
    return np.asarray(equations.nodes[best_first[equations.begins[:-1]]])
