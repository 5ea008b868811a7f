"""An occupancy map for ROS: a folder with ``map.pgm`` and ``map.yaml``, as map_server loads it."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image

from slam.compiled import compiled
from slam.config import SurfelMapConfig
from slam.deskew import deskewed
from slam.errors import InputError
from slam.files.atomic_files import atomic_folder
from slam.limits import ROS_MAP_CELLS
from slam.pose import FloatArray, Pose2D
from slam.run.results.run_record import RunRecord

CountArray = NDArray[np.int32]
_HIT_SHARE: Final = 0.25
"""Share of the beams that reached a cell and ended there, from which it is taken to be occupied, as in GMapping."""
_CELL: Final = 0.05
"""Metres."""
_OCCUPIED, _FREE, _UNKNOWN = 0, 254, 205
_FREE_THRESH: Final = 0.196
"""Just below what 205 stands for, 50 / 255: every map_server, old or new, takes it for unknown."""


@compiled
def count_rays(
    passes: CountArray, hits: CountArray, corner: FloatArray, cell: float, origin: FloatArray, ends: FloatArray,
    echoes: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Add the beams from ``origin`` (2,) to ``ends`` (N, 2) to the counts (rows, columns), which must hold them all.

    Each cell on the way counts a pass, but the one where an echo came from counts a hit. ``corner`` is the outer corner
    of cell [0, 0], metres, map frame. Cells are walked one border after another (Amanatides and Woo 1987).
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
    """Beams of one scan: their origin (2,), ends (N, 2), and which came back (N,); map frame, metres."""

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
        return (self.hits > 0) & (self.hits >= _HIT_SHARE * (self.hits + self.passes))

    @property
    def free(self) -> NDArray[np.bool_]:
        """Cells that beams went through, and that are not occupied."""
        return (self.passes > 0) & ~self.occupied


def occupancy(record: RunRecord, cell: float) -> Occupancy:
    """The grid with cells of that side, metres; InputError where it would not fit into memory."""
    low, high = _bounds(record)
    corner = np.floor(low / cell - 1.0) * cell
    columns, rows = (np.ceil((high - corner) / cell) + 2).astype(int).tolist()
    if excess := ROS_MAP_CELLS.excess(rows * columns, f"of {cell} m in its map"):
        raise InputError(f"{record.folder}: {excess}")
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
    for pose, seen in zip(record.traces.final.tolist(), record.observations(), strict=False):
        scan = deskewed(seen.scan, seen.odometry.twist, mount) if config.deskew else seen.scan
        T_map_laser, echoes = Pose2D(*pose) @ mount, scan.echoes
        reach = np.where(echoes, scan.ranges, np.where(scan.ranges == np.inf, min(no_echo_reach, scan.range_max), 0.0))
        told = reach > 0.0
        bearings, reach = scan.bearings[told], reach[told]
        ends = np.column_stack([reach * np.cos(bearings), reach * np.sin(bearings)])
        yield Beams(T_map_laser.translation, T_map_laser.transform(ends), echoes[told])


def write_ros_map(record: RunRecord, out: Path) -> None:
    """Write cells of 5 cm: occupied black, free white, unknown grey; the origin is the lower left corner, map frame."""
    grid = occupancy(record, _CELL)
    header = {
        "image": "map.pgm",
        "mode": "trinary",
        "resolution": _CELL,
        "origin": [*np.round(grid.corner, 6).tolist(), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": _FREE_THRESH,
    }
    with atomic_folder(out) as draft:
        draft.mkdir()
        Image.fromarray(_pixels(grid)).save(draft / "map.pgm")
        (draft / "map.yaml").write_text(yaml.safe_dump(header, sort_keys=False))


def _pixels(grid: Occupancy) -> NDArray[np.uint8]:
    """(rows, columns), the highest row first."""
    pixels = np.full(grid.hits.shape, _UNKNOWN, np.uint8)
    pixels[grid.free] = _FREE
    pixels[grid.occupied] = _OCCUPIED
    return pixels[::-1]
