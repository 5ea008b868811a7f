"""The constellation of a submap: its walls, and the free floor between them."""

from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.mapping.surfel_grid import HITS
from slam.mapping.wall_evidence import evidence_of_hits
from slam.mapping.wall_segments import wall_segments
from slam.pose import FloatArray, Pose2D

MIDDLE_X, MIDDLE_Y, ALONG_X, ALONG_Y, LENGTH = range(5)
"""Columns of walls (M, 5): the middle and the length, metres, and the unit vector from start to end; the floor is on
its left."""
BELIEVED_HITS: Final = 3.0
"""Surfels with fewer hits get this number, so that walls of the shortest length count after a single scan."""
SHORTEST: Final = 0.4
"""Least length of a wall, metres; shorter ones may be legs of tables."""
CELL: Final = 0.25
"""Side of a cell of the floor, metres."""
CELLS: Final = 64
"""Cells of the floor to each side of the origin: 16 m."""
FREE_MARGIN: Final = 0.3
"""Distance from a wall within which no cell counts as free, metres."""
RAYS: Final = 180
"""Number of rays from the origin."""

Floor = NDArray[np.bool_]


class Constellation(NamedTuple):
    """Walls of a submap that are compared to recognise a place, in the frame of a robot pose in its middle."""

    walls: FloatArray
    """(M, 5), in an order that depends only on the walls."""
    free: Floor
    """(2 CELLS, 2 CELLS), [row, column]: True for the cells around the origin where the robot saw free floor."""

    @classmethod
    def of(cls, ends: FloatArray) -> Self:
        """Describe walls (M, 2, 2), [wall, start or end, x or y], metres, around a robot pose in their middle."""
        lines = ends[:, 1] - ends[:, 0]
        lengths = np.hypot(lines[:, 0], lines[:, 1])
        kept = lengths >= SHORTEST
        walls = np.column_stack([ends[kept].mean(axis=1), lines[kept] / lengths[kept, None], lengths[kept]])
        walls = walls[np.lexsort(walls.T)]
        return cls(walls, _free_floor(walls))

    @classmethod
    def of_surfels(cls, surfels: FloatArray, middle: FloatArray, cell: float) -> Self:
        """Describe all walls of surfels (S, 8), in the frame of a robot pose (3,) in their middle.

        Walls seen only once, from afar, are not in the map yet; they help to recognise the place all the same.
        """
        believed = surfels.copy()
        believed[:, HITS] = np.maximum(surfels[:, HITS], BELIEVED_HITS)
        ends = wall_segments(believed, evidence_of_hits(believed), cell)
        return cls.of(Pose2D.from_array(middle).inverse().transform(ends))


@compiled
def _free_floor(walls: FloatArray) -> Floor:
    """Return the floor that rays cross from the origin to the first wall, if they meet the side that was seen."""
    free = np.zeros((2 * CELLS, 2 * CELLS), np.bool_)
    for ray in range(RAYS):
        c, s = np.cos(ray * 2.0 * np.pi / RAYS), np.sin(ray * 2.0 * np.pi / RAYS)
        for step in range(int(2.0 * _free_reach(walls, c, s) / CELL)):
            row, column = cell_of(0.5 * CELL * step * c, 0.5 * CELL * step * s, CELLS)
            if row >= 0:
                free[row, column] = True
    return free


@compiled_on_views
def _free_reach(walls: FloatArray, c: float, s: float) -> float:
    """Return the free distance along a ray, metres; 0 if no wall ends it, or if it meets the back of a wall."""
    nearest, reach = np.inf, 0.0
    for m in range(len(walls)):
        facing = c * walls[m, ALONG_Y] - s * walls[m, ALONG_X]  # sine from the ray to the wall
        if facing == 0.0:
            continue
        x, y = walls[m, MIDDLE_X], walls[m, MIDDLE_Y]
        distance = (x * walls[m, ALONG_Y] - y * walls[m, ALONG_X]) / facing
        if 0.0 < distance < nearest and abs(x * s - y * c) <= 0.5 * walls[m, LENGTH] * abs(facing):
            nearest = distance
            reach = distance - FREE_MARGIN / facing if facing > 0.0 else 0.0
    return reach


@compiled_on_views
def cell_of(x: float, y: float, cells: int) -> tuple[int, int]:
    """Return row and column at a point, of a grid of ``cells`` cells to each side of the origin; -1 and -1 outside."""
    row, column = int(np.floor(y / CELL)) + cells, int(np.floor(x / CELL)) + cells
    if 0 <= row < 2 * cells and 0 <= column < 2 * cells:
        return row, column
    return -1, -1
