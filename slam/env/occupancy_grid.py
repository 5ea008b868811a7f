"""An occupancy grid of a bounded world: the area that the beams of a lidar spanned, and their echoes."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from slam.env.scan_fill import UNKNOWN, mark_scan, measure_seen
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan
from slam.scenario.schema import Scenario

_MARGIN: Final = 1.0
"""Margin of the grid around its contents, metres."""


@dataclass(frozen=True, slots=True)
class Extent:
    """A rectangle along the axes of the map: lower corner and size, metres."""

    low: tuple[float, float]
    size: tuple[float, float]

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Enclose the solids that the lidar can see, the start and the way-points, with a margin."""
        corners = np.concatenate([np.array(scenario.path), *scenario.world.outlines(scenario.lidar.height)])
        low, high = corners.min(axis=0) - _MARGIN, corners.max(axis=0) + _MARGIN
        return cls((float(low[0]), float(low[1])), (float(high[0] - low[0]), float(high[1] - low[1])))

    def shape(self, cell: float) -> tuple[int, int]:
        """Return rows and columns of a grid with cells of this side, metres."""
        columns, rows = (max(1, round(side / cell)) for side in self.size)
        return rows, columns


def seen_ranges(scan: LaserScan) -> FloatArray:
    """Measure how far each beam saw, metres (N,).

    A beam sees up to its echo. If neither it nor its neighbours have an echo, it sees up to the range limit.

    A single beam without an echo was lost, which happens in front of walls too: it saw nothing, as does a beam that was
    too close or in error.
    """
    seen = np.empty(len(scan.ranges))
    measure_seen(scan.ranges, scan.range_max, seen)
    return seen


def warm_up_occupancy_grid() -> None:
    """Compile the functions that mark cells, before a robot drives in real time."""
    grid = OccupancyGrid(Extent((0.0, 0.0), (1.0, 1.0)), 0.5)
    grid.add_scan(LaserScan(0.0, 0.0, 0.1, 0.0, 1.0, np.ones(2)), Pose2D())


class OccupancyGrid:
    """Square cells, each unknown, free or a wall. The size is that of the world, however long the run."""

    def __init__(self, extent: Extent, cell: float) -> None:
        self.cell = cell
        self.low = np.array(extent.low)
        self.cells: NDArray[np.uint8] = np.zeros(extent.shape(cell), np.uint8)
        """State of each cell: UNKNOWN, FREE or WALL; row along y."""

    def add_scan(self, scan: LaserScan, T_map_laser: Pose2D) -> float:
        """Mark the cells that one scan sees, up to ``seen_ranges``; return the newly seen area, m^2."""
        x, y = (T_map_laser.translation - self.low) / self.cell
        lengths, headings = seen_ranges(scan) / self.cell, T_map_laser.theta + scan.lidar.angles
        ends = np.array([x + lengths * np.cos(headings), y + lengths * np.sin(headings)])
        newly = mark_scan(self.cells, x, y, ends, scan.echoes, scan.lidar.whole_turn)
        return float(newly * self.cell**2)

    def at(self, points: FloatArray) -> NDArray[np.uint8]:
        """Return the cells at these points (..., 2), metres; UNKNOWN outside."""
        columns, rows = np.moveaxis(np.floor((points - self.low) / self.cell).astype(np.int64), -1, 0)
        inside = (rows >= 0) & (rows < self.cells.shape[0]) & (columns >= 0) & (columns < self.cells.shape[1])
        return np.where(inside, self.cells[rows * inside, columns * inside], np.uint8(UNKNOWN))
