"""An occupancy grid of a bounded world: what the beams of a lidar ran through and met."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled_on_views
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan
from slam.scenario.schema import Scenario

UNKNOWN, FREE, WALL = 0, 1, 2
_MARGIN: Final = 1.0
"""Margin of the grid around all that it must hold, metres."""


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


def seen_ranges(scan: LaserScan) -> FloatArray:
    """Measure how far each beam saw, metres (N,).

    That is to its echo, or as far as the sensor reaches where neither it nor its neighbours have one.

    A lone beam without an echo was lost, which happens before walls too: it saw nothing, as does one that was too close
    or in error.
    """
    silent = np.pad(np.isposinf(scan.ranges), 1, mode="edge")
    open_space = silent[:-2] & silent[1:-1] & silent[2:]
    return np.where(scan.echoes, scan.ranges, np.where(open_space, scan.range_max, 0.0))


def warm_up_occupancy_grid() -> None:
    """Compile what marks the cells, before a robot drives whose time is real."""
    grid = OccupancyGrid(Extent((0.0, 0.0), (1.0, 1.0)), 0.5)
    grid.add_scan(LaserScan(0.0, 0.0, 0.1, 0.0, 1.0, np.ones(2)), Pose2D())


class OccupancyGrid:
    """Square cells, each unknown, free or a wall. Its size is that of the world, however long the run."""

    def __init__(self, extent: Extent, cell: float) -> None:
        self.cell = cell
        self.low = np.array(extent.low)
        columns, rows = (max(1, round(side / cell)) for side in extent.size)
        self.cells: NDArray[np.uint8] = np.zeros((rows, columns), np.uint8)
        """UNKNOWN, FREE or WALL; row along y."""

    def add_scan(self, scan: LaserScan, T_map_laser: Pose2D) -> float:
        """Mark what the beams of one scan ran through and met, as far as ``seen_ranges``; the newly seen area, m^2."""
        x, y = (T_map_laser.translation - self.low) / self.cell
        headings = T_map_laser.theta + scan.lidar.angles
        newly = mark_rays(self.cells, x, y, headings, seen_ranges(scan) / self.cell, scan.echoes) * self.cell**2
        return float(newly)

    def at(self, points: FloatArray) -> NDArray[np.uint8]:
        """The cells in which these points (..., 2), metres, lie; UNKNOWN outside."""
        columns, rows = np.moveaxis(np.floor((points - self.low) / self.cell).astype(np.int64), -1, 0)
        inside = (rows >= 0) & (rows < self.cells.shape[0]) & (columns >= 0) & (columns < self.cells.shape[1])
        return np.where(inside, self.cells[rows * inside, columns * inside], np.uint8(0))


@compiled_on_views
def mark_rays(
    cells: NDArray[np.uint8], x: float, y: float, headings: FloatArray, lengths: FloatArray, echoes: NDArray[np.bool_]
) -> int:
    """Mark what each ray from (x, y) runs through as FREE, and where an echo came from as WALL; how many were UNKNOWN.

    ``cells`` (rows, columns) is written to, row along y; x, y and ``lengths`` (N,) are in cells, ``headings`` (N,) in
    radians. A ray of length 0 or less marks nothing. A cell once seen as WALL stays one. Outside there is nothing.
    """
    found = 0
    for k in range(len(headings)):
        if lengths[k] > 0.0:
            found += march(cells, x, y, np.cos(headings[k]), np.sin(headings[k]), lengths[k], echoes[k])
    return found


@compiled_on_views
def march(cells: NDArray[np.uint8], x: float, y: float, dx: float, dy: float, length: float, echo: bool) -> int:
    """March along one ray, from border to border of the cells it crosses (Amanatides and Woo, 1987)."""
    column, row = int(np.floor(x)), int(np.floor(y))
    step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    per_x, per_y = 1.0 / max(abs(dx), 1e-12), 1.0 / max(abs(dy), 1e-12)  # along the ray, from border to border
    at_x = (column + 1 - x if dx > 0.0 else x - column) * per_x
    at_y = (row + 1 - y if dy > 0.0 else y - row) * per_y
    end_column, end_row = int(np.floor(x + dx * length)), int(np.floor(y + dy * length))
    # A ray that stays away from the rim, by a cell for rounding, needs no look at it on its way.
    inside = 1 <= min(column, end_column) and max(column, end_column) < cells.shape[1] - 1
    inside &= 1 <= min(row, end_row) and max(row, end_row) < cells.shape[0] - 1
    found = 0
    while min(at_x, at_y) < length:
        if inside:
            found += cells[row, column] == UNKNOWN
            cells[row, column] = max(cells[row, column], np.uint8(FREE))
        else:
            found += _mark(cells, row, column, FREE)
        if at_x < at_y:
            at_x += per_x
            column += step_x
        else:
            at_y += per_y
            row += step_y
    return found + _mark(cells, row, column, WALL if echo else FREE)


@compiled_on_views
def _mark(cells: NDArray[np.uint8], row: int, column: int, what: int) -> int:
    if row < 0 or column < 0 or row >= cells.shape[0] or column >= cells.shape[1]:
        return 0
    before = cells[row, column]
    cells[row, column] = max(before, what)
    return 1 if before == UNKNOWN else 0
