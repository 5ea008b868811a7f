"""The constellation of a submap: its walls, and the floor that its robot has seen to be free."""

from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.mapping.surfel_grid import HITS
from slam.mapping.wall_evidence import evidence_of_hits
from slam.mapping.wall_segments import wall_segments
from slam.pose import FloatArray, Pose2D, path_lengths

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
VIEWPOINTS_EVERY: Final = 1.0
"""Metres of path from one place where the robot looks round to the next."""
RAYS: Final = 180
"""Rays of one look round."""

Floor = NDArray[np.bool_]


class Constellation(NamedTuple):
    """What is compared to find a place again; the origin is near the middle of the submap's path."""

    walls: FloatArray
    """(M, 5), in an order that depends on nothing but the walls."""
    free: Floor
    """True in the cells (2 CELLS, 2 CELLS), [row, column], that were seen to be free; the origin is in their middle."""

    @classmethod
    def of(cls, ends: FloatArray, path: FloatArray | None = None) -> Self:
        """Walls (M, 2, 2), [wall, start or end, x or y], that were seen from a path (K, 2), metres; from the origin,
        where there is none."""
        lines = ends[:, 1] - ends[:, 0]
        lengths = np.hypot(lines[:, 0], lines[:, 1])
        kept = lengths >= SHORTEST
        walls = np.column_stack([ends[kept].mean(axis=1), lines[kept] / lengths[kept, None], lengths[kept]])
        walls = walls[np.lexsort(walls.T)]
        return cls(walls, _free_floor(walls, np.zeros((1, 2)) if path is None else _viewpoints(path)))

    @classmethod
    def of_surfels(cls, surfels: FloatArray, path: FloatArray, cell: float) -> Self:
        """All walls of surfels (S, 8) in cells so wide, seen from a path (K, 3), in the frame of its middle pose.

        What was seen once, from afar, is no wall of the map yet; it tells of the place all the same.
        """
        believed = surfels.copy()
        believed[:, HITS] = np.maximum(surfels[:, HITS], BELIEVED_HITS)
        ends = wall_segments(believed, evidence_of_hits(believed), cell)
        middle = Pose2D.from_array(path[len(path) // 2]).inverse()
        return cls.of(middle.transform(ends), middle.transform(path[:, :2]))


def _viewpoints(path: FloatArray) -> FloatArray:
    """Points (V, 2) at even distances on a path (K, 2)."""
    way = path_lengths(path)
    at = np.arange(0.0, way[-1] + VIEWPOINTS_EVERY, VIEWPOINTS_EVERY)
    return np.column_stack([np.interp(at, way, path[:, 0]), np.interp(at, way, path[:, 1])])


@compiled
def _free_floor(walls: FloatArray, viewpoints: FloatArray) -> Floor:
    """The floor that rays cross from the viewpoints (V, 2) to the first wall, where they meet the side that was
    seen."""
    free = np.zeros((2 * CELLS, 2 * CELLS), np.bool_)
    for v in range(len(viewpoints)):
        x, y = viewpoints[v]
        for ray in range(RAYS):
            c, s = np.cos(ray * 2.0 * np.pi / RAYS), np.sin(ray * 2.0 * np.pi / RAYS)
            reach = _free_reach(walls, x, y, c, s)
            for step in range(int(2.0 * reach / CELL)):
                row, column = cell_of(x + 0.5 * CELL * step * c, y + 0.5 * CELL * step * s, CELLS)
                if row >= 0:
                    free[row, column] = True
    return free


@compiled
def _free_reach(walls: FloatArray, x: float, y: float, c: float, s: float) -> float:
    """Metres that are free along a ray from (x, y); none where no wall ends it, or one whose back it meets."""
    nearest, reach = np.inf, 0.0
    for m in range(len(walls)):
        facing = c * walls[m, ALONG_Y] - s * walls[m, ALONG_X]  # sine from the ray to the wall
        if facing == 0.0:
            continue
        dx, dy = walls[m, MIDDLE_X] - x, walls[m, MIDDLE_Y] - y
        way = (dx * walls[m, ALONG_Y] - dy * walls[m, ALONG_X]) / facing
        if 0.0 < way < nearest and abs(dx * s - dy * c) <= 0.5 * walls[m, LENGTH] * abs(facing):
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
