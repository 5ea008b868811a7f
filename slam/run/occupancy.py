"""An occupancy grid of a run: cells in which beams ended, and cells that they passed."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.config import SlamConfig, SurfelMapConfig
from slam.deskew import deskewed
from slam.errors import InputError
from slam.limits import ROS_MAP_CELLS
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation
from slam.run.results.run_record import RunRecord

CountArray = NDArray[np.int32]
CELL: Final = 0.05
"""Side of a cell of the maps for ROS, metres."""
OCCUPIED, FREE, UNKNOWN = 100, 0, -1
"""Cells of a ``nav_msgs/OccupancyGrid``."""
_HIT_SHARE: Final = 0.25
"""A cell is occupied if at least this share of the beams that reached it ended in it, as in GMapping."""


@compiled
def count_rays(
    passes: CountArray, hits: CountArray, corner: FloatArray, cell: float, origin: FloatArray, ends: FloatArray,
    echoes: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Add the beams from ``origin`` (2,) to ``ends`` (N, 2) to the counts (rows, columns), which must contain them all.

    Each cell on the way counts a pass, except the one with the echo, which counts a hit. ``corner`` is the outer corner
    of cell [0, 0], metres, map frame. Cells are traversed border by border (Amanatides and Woo 1987).
    """
    x0, y0 = (origin[0] - corner[0]) / cell, (origin[1] - corner[1]) / cell
    for j in range(len(ends)):
        x1, y1 = (ends[j, 0] - corner[0]) / cell, (ends[j, 1] - corner[1]) / cell
        column, row = int(np.floor(x0)), int(np.floor(y0))
        last_column, last_row = int(np.floor(x1)), int(np.floor(y1))
        dx, dy = x1 - x0, y1 - y0
        step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
        t_x = (column + (step_x > 0) - x0) / dx if dx != 0.0 else np.inf
        t_y = (row + (step_y > 0) - y0) / dy if dy != 0.0 else np.inf
        for _ in range(abs(last_column - column) + abs(last_row - row)):
            passes[row, column] += 1
            if (t_x < t_y and column != last_column) or row == last_row:
                column += step_x
                t_x += step_x / dx
            else:
                row += step_y
                t_y += step_y / dy
        if echoes[j]:
            hits[row, column] += 1
        else:
            passes[row, column] += 1


class Beams(NamedTuple):
    """Beams of one scan: their origin (2,), ends (N, 2), and whether they have an echo (N,); metres."""

    origin: FloatArray
    ends: FloatArray
    echoes: NDArray[np.bool_]

    @classmethod
    def of(cls, seen: Observation, config: SlamConfig, T_base_laser: Pose2D) -> Self:
        """Return the valid beams, sensor frame, deskewed if the method does so."""
        no_echo_reach = config.map.no_echo_reach if isinstance(config.map, SurfelMapConfig) else 0.0
        scan = deskewed(seen.scan, seen.odometry.twist, T_base_laser) if config.deskew else seen.scan
        echoes = scan.echoes
        reach = np.where(echoes, scan.ranges, np.where(scan.ranges == np.inf, min(no_echo_reach, scan.range_max), 0.0))
        valid = reach > 0.0
        bearings, reach = scan.bearings[valid], reach[valid]
        ends = np.column_stack([reach * np.cos(bearings), reach * np.sin(bearings)])
        return cls(np.zeros(2), ends, echoes[valid])

    def moved(self, T: Pose2D) -> Self:
        """Transform the beams by this pose; they begin at its origin."""
        return self._replace(origin=T.translation, ends=T.transform(self.ends))

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest x and y."""
        low, high = self.ends.min(axis=0, initial=np.inf), self.ends.max(axis=0, initial=-np.inf)
        return np.minimum(self.origin, low), np.maximum(self.origin, high)


@dataclass(frozen=True, slots=True, eq=False)
class Occupancy:
    """Counts (rows, columns), the lowest row first; ``corner`` is the outer corner of cell [0, 0], map frame."""

    passes: CountArray
    hits: CountArray
    corner: FloatArray
    cell: float

    @classmethod
    def empty(cls, low: FloatArray, high: FloatArray, cell: float) -> Self:
        """Make a grid from ``low`` to ``high``; InputError if it would not fit into memory."""
        corner = np.floor(low / cell - 1.0) * cell
        columns, rows = (np.ceil((high - corner) / cell) + 2).astype(int).tolist()
        if excess := ROS_MAP_CELLS.excess(rows * columns, f"of {cell} m in its map"):
            raise InputError(excess)
        return cls(np.zeros((rows, columns), np.int32), np.zeros((rows, columns), np.int32), corner, cell)

    def add(self, beams: Beams) -> None:
        """Count the beams of a scan, map frame, which the grid must contain."""
        count_rays(self.passes, self.hits, self.corner, self.cell, *beams)

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Cells in which enough beams ended."""
        return (self.hits > 0) & (self.hits >= _HIT_SHARE * (self.hits + self.passes))

    @property
    def free(self) -> NDArray[np.bool_]:
        """Cells that beams went through, and that are not occupied."""
        return (self.passes > 0) & ~self.occupied

    @property
    def cells(self) -> NDArray[np.int8]:
        """Every cell as OCCUPIED, FREE or UNKNOWN."""
        occupied = self.occupied
        seen = np.where(self.passes > 0, np.int8(FREE), np.int8(UNKNOWN))
        return np.where(occupied, np.int8(OCCUPIED), seen)


def occupancy(record: RunRecord, cell: float = CELL) -> Occupancy:
    """Make the final grid of a run; InputError if it would not fit into memory."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for beams in _beams(record):
        lowest, highest = beams.bounds
        low, high = np.minimum(low, lowest), np.maximum(high, highest)
    try:
        grid = Occupancy.empty(low, high, cell)
    except InputError as excess:
        raise InputError(f"{record.folder}: {excess}") from None
    for beams in _beams(record):
        grid.add(beams)
    return grid


def _beams(record: RunRecord) -> Iterator[Beams]:
    """Yield the beams of every scan, map frame."""
    mount = record.T_base_laser
    for pose, seen in zip(record.traces.final.tolist(), record.observations(), strict=False):
        yield Beams.of(seen, record.config.slam, mount).moved(Pose2D(*pose) @ mount)
