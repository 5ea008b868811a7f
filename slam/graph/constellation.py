"""The constellation of a submap: its walls, and the floor that they leave free."""

from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.mapping.surfel_grid import HITS
from slam.mapping.wall_evidence import evidence_of_hits
from slam.mapping.wall_segments import wall_segments
from slam.pose import FloatArray, Pose2D

MIDDLE_X, MIDDLE_Y, ALONG_X, ALONG_Y, LENGTH = range(5)
"""Columns of walls (M, 5): the middle and the length, metres, and the unit vector from start to end, which has the
floor on its left."""
BELIEVED_HITS: Final = 3.0
"""Scans by which a surfel counts as seen, at least: then a wall of the shortest length is one."""
SHORTEST: Final = 0.4
"""Metres: shorter walls are legs of tables as often as walls."""
CELL: Final = 0.25
"""Side of a cell of the floor, metres."""
CELLS: Final = 64
"""Cells of the floor to each side of the origin: 16 m."""
FREE_MARGIN: Final = 0.3
"""Metres from a wall within which nothing is called free."""
RAYS: Final = 180
"""Rays from the origin."""

Floor = NDArray[np.bool_]


class Constellation(NamedTuple):
    """Walls that are compared to find a place again, in the frame of a robot's pose in the middle of the submap."""

    walls: FloatArray
    """(M, 5), in an order that depends on nothing but the walls."""
    free: Floor
    """True in the cells (2 CELLS, 2 CELLS), [row, column], about the origin where the robot saw free floor."""

    @classmethod
    def of(cls, ends: FloatArray) -> Self:
        """Walls (M, 2, 2), [wall, start or end, x or y], metres, about a place of the robot in their middle."""
        lines = ends[:, 1] - ends[:, 0]
        lengths = np.hypot(lines[:, 0], lines[:, 1])
        kept = lengths >= SHORTEST
        walls = np.column_stack([ends[kept].mean(axis=1), lines[kept] / lengths[kept, None], lengths[kept]])
        walls = walls[np.lexsort(walls.T)]
        return cls(walls, _free_floor(walls))

    @classmethod
    def of_surfels(cls, surfels: FloatArray, middle: FloatArray, cell: float) -> Self:
        """All walls of surfels (S, 8), in cells so wide, in the frame of a pose (3,) of the robot in their middle.

        What was seen once, from afar, is no wall of the map yet; it tells of the place all the same.
        """
        believed = surfels.copy()
        believed[:, HITS] = np.maximum(surfels[:, HITS], BELIEVED_HITS)
        ends = wall_segments(believed, evidence_of_hits(believed), cell)
        return cls.of(Pose2D.from_array(middle).inverse().transform(ends))


@compiled
def _free_floor(walls: FloatArray) -> Floor:
    """The floor that rays cross from the origin to the first wall, where they meet the side that was seen."""
    free = np.zeros((2 * CELLS, 2 * CELLS), np.bool_)
    for ray in range(RAYS):
        c, s = np.cos(ray * 2.0 * np.pi / RAYS), np.sin(ray * 2.0 * np.pi / RAYS)
        for step in range(int(2.0 * _free_reach(walls, c, s) / CELL)):
            row, column = cell_of(0.5 * CELL * step * c, 0.5 * CELL * step * s, CELLS)
            if row >= 0:
                free[row, column] = True
    return free


@compiled
def _free_reach(walls: FloatArray, c: float, s: float) -> float:
    """Metres that are free along a ray; none where no wall ends it, or one whose back it meets."""
    nearest, reach = np.inf, 0.0
    for m in range(len(walls)):
        facing = c * walls[m, ALONG_Y] - s * walls[m, ALONG_X]  # sine from the ray to the wall
        if facing == 0.0:
            continue
        x, y = walls[m, MIDDLE_X], walls[m, MIDDLE_Y]
        way = (x * walls[m, ALONG_Y] - y * walls[m, ALONG_X]) / facing
        if 0.0 < way < nearest and abs(x * s - y * c) <= 0.5 * walls[m, LENGTH] * abs(facing):
            nearest = way
            reach = way - FREE_MARGIN / facing if facing > 0.0 else 0.0
    return reach


@compiled
def cell_of(x: float, y: float, cells: int) -> tuple[int, int]:
    """Row and column at a point, of a grid of so many cells to each side of the origin; -1 and -1 beyond its border."""
    row, column = int(np.floor(y / CELL)) + cells, int(np.floor(x / CELL)) + cells
    if 0 <= row < 2 * cells and 0 <= column < 2 * cells:
        return row, column
    return -1, -1
