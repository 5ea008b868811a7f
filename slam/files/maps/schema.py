"""``map.json``, version 1: see docs/localization.md."""

from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from slam.config import Section
from slam.limits import MAP_CELLS
from slam.lines.learnt_noise import BANDS, SIZES
from slam.mapping.directions import MAX_CLUSTERS, QUARTER
from slam.mapping.surfel_grid import PIECES

VERSION = 1
PoseRow = tuple[float, float, float]
CovarianceRows = tuple[PoseRow, PoseRow, PoseRow]
SurfelRow = tuple[float, float, float, float, float, float, float, Annotated[int, Field(ge=-1)]]
Count = Annotated[int, Field(ge=-128, le=127)]
EvidenceRow = Annotated[tuple[Count, ...], Field(min_length=PIECES + 1, max_length=PIECES + 1)]
CellRow = tuple[int, int, Annotated[int, Field(ge=0)]]
Metres = Annotated[float, Field(ge=0)]
Size = Annotated[int, Field(gt=0)]


class SavedGrid(Section):
    """The grid of the map: surfels in linked lists, one for each cell, and one of the free rows."""

    cell: Annotated[float, Field(gt=0)]
    corner: tuple[int, int]
    shape: tuple[Size, Size]
    free: Annotated[int, Field(ge=-1)]
    cells: tuple[CellRow, ...]
    surfels: tuple[SurfelRow, ...]
    evidence: tuple[EvidenceRow, ...] = ()
    """Grid.evidence; empty in older maps."""
    way: Metres = 0.0
    """Grid.path_length; 0 in older maps."""
    born: tuple[float, ...] = ()
    """The last column of the surfels; without it, as in older files, all were there from the start."""

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        rows, columns = self.shape
        if excess := MAP_CELLS.excess(rows * columns, "in its shape"):
            raise ValueError(excess)
        if len(self.evidence) not in (0, len(self.surfels)):
            raise ValueError(f"evidence has {len(self.evidence)} rows, for {len(self.surfels)} surfels")
        if self.born and len(self.born) != len(self.surfels):
            raise ValueError(f"born has {len(self.born)} numbers, for {len(self.surfels)} surfels")
        seen = np.zeros(len(self.surfels), np.bool_)
        for row, column, first in self.cells:
            if not (0 <= row - self.corner[0] < rows and 0 <= column - self.corner[1] < columns):
                raise ValueError(f"cell ({row}, {column}) lies outside of the grid")
            self._walk(first, seen, (row, column))
        self._walk(self.free, seen, None)
        if not seen.all():
            raise ValueError(f"surfels[{int(np.argmin(seen))}] is not in any list")
        return self

    def _walk(self, k: int, seen: NDArray[np.bool_], place: tuple[int, int] | None) -> None:
        """Mark a list as visited; ValueError if it is not a list, or contains rows of another one."""
        while k >= 0:
            if k >= len(seen) or seen[k]:
                raise ValueError(f"the list of {place or 'free places'} leads to surfel {k}, which is not its own")
            seen[k] = True
            if problem := _problem(self.surfels[k], place, self.cell):
                raise ValueError(f"surfels[{k}] {problem}")
            k = self.surfels[k][7]


def _problem(surfel: SurfelRow, place: tuple[int, int] | None, cell: float) -> str:
    """Return the fault of a surfel in the list of a cell, or in that of the free rows (None).

    Empty if there is none.
    """
    x, y, nx, ny, information, hits, misses, _ = surfel
    if place is None:
        return "is free but has hits" if hits != 0.0 else ""
    if hits < 1.0 or misses < 0.0 or information <= 0.0:
        return "needs hits of 1 or more, misses of 0 or more, and information above 0"
    if (nx, ny) != (0.0, 0.0) and abs(np.hypot(nx, ny) - 1.0) > 1e-6:
        return "has a normal whose length is not 1, or 0"
    if max(abs(y / cell - place[0] - 0.5), abs(x / cell - place[1] - 0.5)) > 0.5 + 1e-6:
        return f"at ({x:g}, {y:g}) does not lie in its cell {place}"
    return ""


class _WithCovariance(Section):
    """Base of values with a covariance."""

    covariance: CovarianceRows

    @model_validator(mode="after")
    def _is_a_covariance(self) -> Self:
        matrix = np.array(self.covariance)
        scale = max(float(np.abs(matrix).max()), 1e-300)
        if np.abs(matrix - matrix.T).max() > 1e-6 * scale or np.linalg.eigvalsh(matrix).min() < -1e-6 * scale:
            raise ValueError("covariance is not symmetric and positive semidefinite")
        return self


class SavedTile(_WithCovariance):
    """The uncertainty of the map in one tile: see slam/mapping/map_uncertainty.py."""

    tile: tuple[int, int]
    entered: PoseRow


class SavedFrontier(Section):
    """Path since the last new tile: see slam/mapping/map_uncertainty.py."""

    began: PoseRow
    reach: Metres
    drift: CovarianceRows
    widest: CovarianceRows


class SavedDirections(Section):
    """Directions of walls: see slam/mapping/directions.py. None in older maps."""

    total: Metres = 0.0
    clusters: Annotated[
        tuple[tuple[Annotated[float, Field(ge=0, le=QUARTER)], Metres, float], ...], Field(max_length=MAX_CLUSTERS)
    ] = ()


class SavedNoise(Section):
    """Noise of the ranges: see slam/lines/learnt_noise.py. None in older maps."""

    differences: tuple[Annotated[tuple[Metres, ...], Field(min_length=SIZES, max_length=SIZES)], ...] = ()

    @model_validator(mode="after")
    def _has_all_bands(self) -> Self:
        if len(self.differences) not in (0, BANDS):
            raise ValueError(f"differences: has {len(self.differences)} bands of range, not {BANDS}")
        return self


class SavedRobot(_WithCovariance):
    """The robot at the end of the run."""

    T_map_base: PoseRow
    T_odom_base: PoseRow | None
    T_map_mapped: PoseRow | None
    T_map_matched: PoseRow | None
    T_map_added: PoseRow | None
    growth: Annotated[float, Field(ge=1)]
    """SurfelMapperState.odometry_inflation."""
    misfits: Annotated[int, Field(ge=0)]
    """SurfelMapperState.bad_matches."""
    excess: tuple[Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)]] = (0.0, 0.0)
    """SurfelMapperState.odometry_excess; empty in older maps."""
    stamp: float | None = None
    """SurfelMapperState.stamp; None in older maps."""
    tile: tuple[int, int] | None
    frontier: SavedFrontier | None = None
    """MapUncertainty.frontier; empty in older maps."""


class MapDocument(Section):
    """The whole file."""

    format: Literal["hopslam map"]
    version: Literal[1]
    grid: SavedGrid
    tiles: tuple[SavedTile, ...]
    directions: SavedDirections = SavedDirections()
    noise: SavedNoise = SavedNoise()
    robot: SavedRobot

    @model_validator(mode="after")
    def _the_robot_is_in_a_tile(self) -> Self:
        tiles = [saved.tile for saved in self.tiles]
        if len(set(tiles)) < len(tiles):
            raise ValueError("tiles: one occurs twice")
        if self.robot.tile is not None and self.robot.tile not in tiles:
            raise ValueError(f"robot.tile {self.robot.tile} is not one of the tiles")
        return self
