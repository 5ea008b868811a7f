"""An occupancy map for ROS: a folder with ``map.pgm`` and ``map.yaml``, as map_server loads it."""

from pathlib import Path
from typing import Final

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image

from slam.files.atomic_files import atomic_folder
from slam.run.occupancy import CELL, Occupancy, occupancy
from slam.run.results.run_record import RunRecord

_OCCUPIED, _FREE, _UNKNOWN = 0, 254, 205
_FREE_THRESH: Final = 0.196
"""A little less than 50 / 255, the occupancy of the grey value 205, so that every version of map_server reads that
value as unknown."""


def write_ros_map(record: RunRecord, out: Path) -> None:
    """Write cells of 5 cm: occupied black, free white, unknown grey; the origin is the lower left corner, map frame."""
    grid = occupancy(record)
    header = {
        "image": "map.pgm",
        "mode": "trinary",
        "resolution": CELL,
        "origin": [*np.round(grid.corner, 6).tolist(), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": _FREE_THRESH,
    }
    with atomic_folder(out) as draft:
        draft.mkdir()
        Image.fromarray(_pixels(grid)).save(draft / "map.pgm")
        (draft / "map.yaml").write_text(yaml.safe_dump(header, sort_keys=False), encoding="utf-8", newline="\n")


def _pixels(grid: Occupancy) -> NDArray[np.uint8]:
    """Make the image, (rows, columns), the highest row first."""
    pixels = np.full(grid.hits.shape, _UNKNOWN, np.uint8)
    pixels[grid.free] = _FREE
    pixels[grid.occupied] = _OCCUPIED
    return pixels[::-1]
