"""The occupancy grid of a run: all its scans, at their estimated poses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.config import SurfelMapConfig
from slam.deskew import deskewed
from slam.errors import InputError
from slam.pose import FloatArray, Pose2D
from slam.run.export.ray_counts import CountArray, count_rays
from slam.run.results.run_record import RunRecord

_OCCUPIED: Final = 0.25
"""Share of the beams that reached a cell and ended there, from which it is taken to be occupied, as in GMapping."""
_MOST_CELLS: Final = 100_000_000


class Beams(NamedTuple):
    """Of one scan, map frame, metres: from where, (2,), to where, (N, 2), and which came back, (N,)."""

    origin: FloatArray
    ends: FloatArray
    echoes: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Occupancy:
    """Counts (rows, columns), the lowest row first; ``corner`` is the outer corner of cell [0, 0], map frame."""

    passes: CountArray
    hits: CountArray
    corner: FloatArray
    cell: float

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Cells in which enough beams ended."""
        return (self.hits > 0) & (self.hits >= _OCCUPIED * (self.hits + self.passes))

    @property
    def free(self) -> NDArray[np.bool_]:
        """Cells that beams went through, and that are not occupied."""
        return (self.passes > 0) & ~self.occupied


def occupancy(record: RunRecord, cell: float) -> Occupancy:
    """The grid with cells of that side, metres; InputError where it would not fit into memory."""
    low, high = _bounds(record)
    corner = np.floor(low / cell - 1.0) * cell
    columns, rows = (np.ceil((high - corner) / cell) + 2).astype(int).tolist()
    if rows * columns > _MOST_CELLS:
        raise InputError(f"{record.folder}: its map would have {columns} x {rows} cells of {cell} m; too many")
    grid = Occupancy(np.zeros((rows, columns), np.int32), np.zeros((rows, columns), np.int32), corner, cell)
    for beams in _beams(record):
        count_rays(grid.passes, grid.hits, corner, cell, *beams)
    return grid


def _bounds(record: RunRecord) -> tuple[FloatArray, FloatArray]:
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for origin, ends, _ in _beams(record):
        low = np.minimum(np.minimum(low, origin), ends.min(axis=0, initial=np.inf))
        high = np.maximum(np.maximum(high, origin), ends.max(axis=0, initial=-np.inf))
    return low, high


def _beams(record: RunRecord) -> Iterator[Beams]:
    """The beams of every scan that say something, with the motion of the robot undone where the method did so too."""
    config, mount = record.config.slam, record.T_base_laser
    no_echo_reach = config.map.no_echo_reach if isinstance(config.map, SurfelMapConfig) else 0.0
    for pose, seen in zip(record.traces.estimate, record.observations(), strict=False):
        scan = deskewed(seen.scan, seen.odometry.twist, mount) if config.deskew else seen.scan
        T_map_laser, echoes = Pose2D.from_array(pose) @ mount, scan.echoes
        reach = np.where(echoes, scan.ranges, np.where(scan.ranges == np.inf, min(no_echo_reach, scan.range_max), 0.0))
        told = reach > 0.0
        bearings, reach = scan.bearings[told], reach[told]
        ends = np.column_stack([reach * np.cos(bearings), reach * np.sin(bearings)])
        yield Beams(T_map_laser.translation, T_map_laser.transform(ends), echoes[told])
