"""The map of this project: surfels, short pieces of wall that know from which side they were seen.

It grows with the area that was seen and not with time: a cell has one surfel for each wall in it and each side of that.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from slam.config import SurfelMapConfig
from slam.lines.segments import IntArray
from slam.mapping.surfel_updates import HITS, NX, NY, Grid, carve, free_ranges, put, room
from slam.mapping.wall_segments import wall_segments
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

MARGIN: Final = 64
"""Cells by which the grid is made larger than what it must cover."""


class SurfelMap:
    """Surfels in a grid; the walls that they make are at ``ends``."""

    def __init__(self, config: SurfelMapConfig, grid: Grid | None = None) -> None:
        self.config = config
        self.grid = grid or Grid(
            head=np.full((2 * MARGIN, 2 * MARGIN), -1, np.int32),
            next=np.full(1024, -1, np.int32),
            surfels=np.zeros((1024, 7)),
            corner=np.array([-MARGIN, -MARGIN]),
            cell=config.cell,
            used=np.array([0, -1, 0]),
        )

    def __len__(self) -> int:
        """Number of surfels."""
        return int(self.grid.used[2])

    @property
    def surfels(self) -> FloatArray:
        """All there are, as in surfel_updates.py, shape (S, 7), map frame."""
        taken = self.grid.surfels[: self.grid.used[0]]
        return taken[taken[:, HITS] > 0.0]

    @property
    def points(self) -> FloatArray:
        """Their centres, shape (S, 2), metres, map frame."""
        return self.surfels[:, :2]

    @property
    def ends(self) -> FloatArray:
        """Start and end of every wall, shape (M, 2, 2): [wall, start or end, x or y]; metres, map frame."""
        surfels = self.surfels
        return wall_segments(surfels[(surfels[:, NX] != 0.0) | (surfels[:, NY] != 0.0)], self.config.cell).ends

    @property
    def nbytes(self) -> int:
        """Memory of the map."""
        return sum(array.nbytes for array in self.grid if isinstance(array, np.ndarray))

    def add(self, facets: FloatArray, scan: LaserScan, T_map_laser: Pose2D) -> None:
        """Put the facets (F, 7) of a scan into the map, and let fade what its beams went through."""
        config, pose = self.config, T_map_laser.as_array()
        if len(facets):
            self._cover(*room(facets, pose, self.grid.cell))
            put(self.grid, facets, pose, config.gate, float(config.max_hits), config.pose_sigma)
        free = free_ranges(scan.ranges, scan.range_min, scan.range_max, config.no_echo_reach)
        carve(
            self.grid, free, scan.angle_min, scan.angle_increment, pose, config.carve_reach, config.free_margin,
            config.miss_ratio,
        )  # fmt: skip

    def _cover(self, low: IntArray, high: IntArray, most: int) -> None:
        """Make room for so many surfels in the cells from ``low`` to ``high``, rows and columns (2,)."""
        grid, shape = self.grid, np.array(self.grid.head.shape)
        if (low < grid.corner).any() or (high >= grid.corner + shape).any():
            corner = np.minimum(grid.corner, low - MARGIN)
            head = np.full(np.maximum(grid.corner + shape, high + MARGIN) - corner, -1, np.int32)
            row, column = grid.corner - corner
            head[row : row + shape[0], column : column + shape[1]] = grid.head
            grid = grid._replace(head=head, corner=corner)
        if grid.used[0] + most > len(grid.surfels):
            size = 2 * len(grid.surfels) + most
            surfels, following = np.zeros((size, 7)), np.full(size, -1, np.int32)
            surfels[: len(grid.surfels)], following[: len(grid.next)] = grid.surfels, grid.next
            grid = grid._replace(surfels=surfels, next=following)
        self.grid = grid
