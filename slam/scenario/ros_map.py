"""A ROS map, ``map.yaml`` and its image, as solids."""

import struct
import warnings
from functools import lru_cache
from pathlib import Path
from typing import Final, Literal, Self

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError
from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator, model_validator

from slam.compiled import compiled
from slam.config import Section
from slam.limits import PIXELS, SOLIDS
from slam.pose import FloatArray, Pose2D
from slam.scenario.solids import Prism
from slam.scenario.validation_message import validation_message
from slam.scenario.values import Positive
from slam.scenario.yaml_file import YAML_ERRORS, explain_yaml_error, load_yaml

_IMAGES: Final = ("PPM", "PNG", "BMP")
"""Pillow's names of the accepted formats; PPM includes PGM, binary (P5) and plain (P2)."""
_NO_IMAGE: Final = (
    UnidentifiedImageError, Image.DecompressionBombError, ValueError, struct.error, SyntaxError, EOFError
)  # fmt: skip
"""Exceptions of Pillow for damaged files, beside OSError."""


class MapHeader(BaseModel):
    """Keys of a ``map.yaml`` that are used, as in map_server; others are ignored."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    image: str
    """Path, relative to the header's own folder."""
    resolution: Positive
    """Side of a cell, metres."""
    origin: tuple[float, float, float]
    """Pose of the lower left corner of the image in the map frame: x, y (m), yaw (rad)."""
    negate: bool = False
    """True if white is occupied."""
    occupied_thresh: float = Field(0.65, ge=0, le=1)
    """Cells darker than this, 0 white to 1 black, are occupied."""
    mode: Literal["trinary", "scale"] = "trinary"
    """Mode of the image; occupied cells are the same in both, and ``raw`` is not supported."""


class RosMap(Section):
    """Occupied cells of a ROS map, raised to solids."""

    file: str
    """Path of the ``map.yaml``; a relative path starts at the scenario file."""
    height: Positive = 1.0
    """Height of the solids, metres."""

    def prisms(self) -> list[Prism]:
        """Make rectangles that together cover exactly the occupied cells. They may overlap."""
        path = Path(self.file)
        return [Prism(footprint, 0.0, self.height) for footprint in _footprints(path, path.stat().st_mtime_ns)]

    @field_validator("file")
    @classmethod
    def _from_the_scenario_file(cls, file: str, info: ValidationInfo) -> str:
        folder: Path = (info.context or {}).get("folder", Path())
        return str((folder / file).resolve())

    @model_validator(mode="after")
    def _readable(self) -> Self:
        try:
            self.prisms()
        except OSError as error:
            raise ValueError(f"{error.filename or self.file}: {error.strerror or error}") from error
        return self


@lru_cache(maxsize=8)
def _footprints(path: Path, changed: int) -> FloatArray:
    """Return corners (N, 4, 2) of rectangles over the occupied cells, map frame.

    ValueError and OSError name the file.
    """
    header = _read_header(path)
    cells = merge_cells(_occupied(path.parent / header.image, header), SOLIDS.most + 1)
    if excess := SOLIDS.excess(len(cells)):
        raise ValueError(f"{path.parent / header.image}: {excess}")
    row, column, rows, columns = cells.T[:, :, np.newaxis].astype(np.float64)
    x = np.concatenate([column, column + columns, column + columns, column], axis=1)
    y = np.concatenate([row, row, row + rows, row + rows], axis=1)
    corners = np.stack([x, y], axis=-1) * header.resolution
    return Pose2D(*header.origin).transform(corners.reshape(-1, 2)).reshape(-1, 4, 2)


def _read_header(path: Path) -> MapHeader:
    try:
        return MapHeader.model_validate(load_yaml(path.read_text(encoding="utf-8")))
    except ValidationError as errors:
        key_path, reason = validation_message(errors, MapHeader)
        key = ".".join(map(str, key_path)) or "the header of a ROS map"
        raise ValueError(f"{path}: {key}: {reason}") from errors
    except YAML_ERRORS as error:
        line, fault = explain_yaml_error(error)
        raise ValueError(f"{path}{f':{line}' if line else ''}: not valid YAML: {fault}") from error


def _occupied(path: Path, header: MapHeader) -> NDArray[np.bool_]:
    """Read the occupied cells, (rows, columns), the lowest row first."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # PIXELS is a lower limit
            image = Image.open(path, formats=_IMAGES)
        with image:
            levels, excess = np.zeros((0, 0), np.uint8), PIXELS.excess(image.width * image.height)
            if excess is None:
                levels = np.asarray(image if image.mode.startswith("I") else image.convert("L"))  # I: 16 bits
    except _NO_IMAGE as error:
        raise ValueError(f"{path}: not an image in a format that maps come in (PGM, PNG, BMP)") from error
    if excess is not None:
        raise ValueError(f"{path}: {excess}")
    most = 255 if levels.dtype == np.uint8 else 65535
    grey = np.arange(most + 1) / most
    occupied = (grey if header.negate else 1.0 - grey) > header.occupied_thresh
    return np.ascontiguousarray(occupied[levels.clip(0, most)][::-1])


@compiled
def _rows_occupied(occupied: NDArray[np.bool_], row: int, column: int, columns: int, limit: int) -> int:
    """Count the rows from ``row`` on, at most ``limit``, that are occupied in all of ``columns`` columns."""
    for rows in range(limit):
        for k in range(column, column + columns):
            if not occupied[row + rows, k]:
                return rows
    return limit


@compiled
def merge_cells(occupied: NDArray[np.bool_], most: int = SOLIDS.most) -> NDArray[np.int64]:
    """Return rectangles (N, 4) of row, column, rows, columns that cover the occupied cells, each cell at least once.

    There are at most ``most`` of them.

    The algorithm is greedy: from each uncovered cell, in reading order, it takes the larger of two rectangles, one
    grown along the row first, the other along the column first.
    """
    height, width = occupied.shape
    covered = np.zeros_like(occupied)
    found = np.empty((min(occupied.sum(), most), 4), np.int64)
    count = 0
    for row in range(height):
        for column in range(width):
            if not occupied[row, column] or covered[row, column] or count == len(found):
                continue
            wide = _rows_occupied(occupied.T, column, row, 1, width - column)
            wide_rows = _rows_occupied(occupied, row, column, wide, height - row)
            rows = _rows_occupied(occupied, row, column, 1, height - row)
            columns = _rows_occupied(occupied.T, column, row, rows, width - column)
            if wide * wide_rows >= rows * columns:
                rows, columns = wide_rows, wide
            covered[row : row + rows, column : column + columns] = True
            found[count] = row, column, rows, columns
            count += 1
    return found[:count].copy()
