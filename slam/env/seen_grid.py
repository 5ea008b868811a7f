"""What a lidar has seen of a bounded world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slam.env.ray_marching import mark_rays
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan
from slam.scenario.schema import Scenario

MARGIN = 1.0
"""Of the grid around all that it must hold, metres."""


@dataclass(frozen=True, slots=True)
class Extent:
    """A rectangle along the axes of the map: lower corner and size, metres."""

    low: tuple[float, float]
    size: tuple[float, float]

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Around the solids that the lidar can see, the start and the way-points, with a margin."""
        start = scenario.robot.start
        places = np.array([(start.x, start.y), *scenario.route.waypoints])
        corners = np.concatenate([places, *scenario.world.outlines(scenario.lidar.height)])
        low, high = corners.min(axis=0) - MARGIN, corners.max(axis=0) + MARGIN
        return cls((float(low[0]), float(low[1])), (float(high[0] - low[0]), float(high[1] - low[1])))


def sight(scan: LaserScan) -> FloatArray:
    """How far each beam saw, shape (N,), metres: to its echo, or as far as the sensor reaches where neither the beam
    nor its neighbours have one. A lone beam without an echo was lost, which happens before walls too: it saw nothing,
    as does one that was too close or in error."""
    silent = np.pad(np.isposinf(scan.ranges), 1, mode="edge")
    open_space = silent[:-2] & silent[1:-1] & silent[2:]
    return np.where(scan.echoes, scan.ranges, np.where(open_space, scan.range_max, 0.0))


def warm_up_seen_grid() -> None:
    """Compile what marks the cells, before a robot drives whose time is real."""
    SeenGrid(Extent((0.0, 0.0), (1.0, 1.0)), 0.5).add(LaserScan(0.0, 0.0, 0.1, 0.0, 1.0, np.ones(2)), Pose2D())


class SeenGrid:
    """Square cells, each unknown, free or a wall. Its size is that of the world, however long the run."""

    def __init__(self, extent: Extent, cell: float) -> None:
        self.cell = cell
        self.low = np.array(extent.low)
        columns, rows = (max(1, round(side / cell)) for side in extent.size)
        self.cells: NDArray[np.uint8] = np.zeros((rows, columns), np.uint8)
        """UNKNOWN, FREE or WALL of ``ray_marching``; row along y."""
        self.area = 0.0
        """Seen so far, m^2."""

    def add(self, scan: LaserScan, T_map_laser: Pose2D) -> float:
        """Mark what the beams of one scan ran through and met, as far as ``sight``; the newly seen area, m^2."""
        x, y = (T_map_laser.translation - self.low) / self.cell
        headings = T_map_laser.theta + scan.lidar.angles
        newly = mark_rays(self.cells, x, y, headings, sight(scan) / self.cell, scan.echoes) * self.cell**2
        self.area += newly
        return float(newly)

    def at(self, points: FloatArray) -> NDArray[np.uint8]:
        """The cells in which these points (..., 2), metres, lie; UNKNOWN outside."""
        columns, rows = np.moveaxis(np.floor((points - self.low) / self.cell).astype(np.int64), -1, 0)
        inside = (rows >= 0) & (rows < self.cells.shape[0]) & (columns >= 0) & (columns < self.cells.shape[1])
        return np.where(inside, self.cells[rows * inside, columns * inside], np.uint8(0))
