"""The occupancy grid of a run in progress, which is rebuilt when a loop is closed."""

from array import array
from typing import Final, NamedTuple

import numpy as np

from slam.config import SlamConfig
from slam.graph.closure import Closure
from slam.pose import FloatArray, Pose2D
from slam.run.occupancy import CELL, Beams, Occupancy
from slam.run.results.traces import carried_on
from slam.run.step import Step

_MARGIN: Final = 5.0
"""Margin of the grid around what was seen, metres, so that it seldom has to grow."""
_STEP: Final = 0.1
"""Least motion between two counted scans, metres and radians: a robot at rest sees the same again."""


class Kept(NamedTuple):
    """The beams of a scan, sensor frame, and its index in the run."""

    number: int
    beams: Beams


class LiveMap:
    """Counts the beams of the scans, and counts them again after the back end has moved their poses.

    Scans of a lost robot do not count. In memory are the scans of every 10 cm of the path: 60 MB for 1 km with 682
    beams.
    """

    def __init__(self, config: SlamConfig, T_base_laser: Pose2D) -> None:
        self._config, self._T_base_laser = config, T_base_laser
        self._kept: list[Kept] = []
        self._last: Pose2D | None = None  # T_local_base at the last counted scan
        self._local = array("d")  # x, y, theta of T_local_base at every scan
        self.grid: Occupancy | None = None
        """The counts; None before the first scan."""

    def add(self, step: Step) -> bool:
        """Take the next step; return True if the grid has changed. InputError if it gets too large."""
        estimate = step.estimate
        local = estimate.T_local_base
        self._local.extend((local.x, local.y, local.theta))
        if estimate.closure is not None:
            self._recount(estimate.closure)
        stood = self._last is not None and not _moved(self._last.between(local))
        if stood or estimate.lost:
            return estimate.closure is not None
        self._last = local
        kept = Kept(step.index, Beams.of(step.observation, self._config, self._T_base_laser))
        self._kept.append(_packed(kept))
        self._count(kept.beams.moved(estimate.T_map_base @ self._T_base_laser))
        return True

    def _recount(self, closure: Closure) -> None:
        """Count all kept scans at their poses in the closure."""
        local = np.array(self._local).reshape(-1, 3)
        own, scans = closure.indices >= 0, np.arange(len(local), dtype=np.float64)
        if not own.any():
            return
        T_laser_base = self._T_base_laser.inverse()
        keys = np.array([(Pose2D.from_array(pose) @ T_laser_base).as_array() for pose in closure.poses[own]])
        poses = carried_on(scans[closure.indices[own]], keys, scans, local)
        self.grid = None
        for number, beams in self._kept:
            self._count(beams.moved(Pose2D.from_array(poses[number]) @ self._T_base_laser))

    def _count(self, beams: Beams) -> None:
        low, high = beams.bounds
        self.grid = _grown(self.grid, low, high)
        self.grid.add(beams)


def _moved(motion: Pose2D) -> bool:
    return motion.distance(Pose2D()) >= _STEP or abs(motion.theta) >= _STEP


def _packed(kept: Kept) -> Kept:
    """Convert to single precision."""
    beams = kept.beams
    return kept._replace(beams=beams._replace(ends=beams.ends.astype(np.float32)))


def _grown(grid: Occupancy | None, low: FloatArray, high: FloatArray) -> Occupancy:
    """Return a grid that has the counts of this one and includes everything from ``low`` to ``high``."""
    if grid is None:
        return Occupancy.empty(low - _MARGIN, high + _MARGIN, CELL)
    far = grid.corner + CELL * np.array(grid.hits.shape[::-1])
    inside = (low > grid.corner + CELL) & (high < far - CELL)
    if inside.all():
        return grid
    margin = np.where(inside, 0.0, _MARGIN)
    larger = Occupancy.empty(np.minimum(low - margin, grid.corner), np.maximum(high + margin, far), CELL)
    column, row = np.rint((grid.corner - larger.corner) / CELL).astype(int).tolist()
    rows, columns = grid.hits.shape
    for old, new in ((grid.hits, larger.hits), (grid.passes, larger.passes)):
        new[row : row + rows, column : column + columns] = old
    return larger
