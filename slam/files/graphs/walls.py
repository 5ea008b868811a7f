"""``walls.geojson``: the line map of a closed run, each wall with its uncertainty."""

import json
from pathlib import Path

import numpy as np

from slam.files.atomic_files import line_feature, write_atomic
from slam.graph.mapped_walls import MappedWalls


def write_walls(path: Path, walls: MappedWalls) -> None:
    """Write the file at once or not at all; metres and radians, map frame, null for an unknown uncertainty."""
    features = [
        line_feature(
            np.round(ends, 4).tolist(),
            {
                "length": round(float(np.hypot(*(ends[1] - ends[0]))), 4),
                "sigma_offset": _rounded(sigma_offset),
                "sigma_direction": _rounded(sigma_direction),
            },
        )
        for ends, (sigma_offset, sigma_direction) in zip(walls.ends, walls.sigmas, strict=True)
    ]
    collection = {"type": "FeatureCollection", "frame": "map", "unit": "metre", "features": features}
    write_atomic(path, json.dumps(collection, indent=1) + "\n")


def _rounded(sigma: float) -> float | None:
    return None if np.isnan(sigma) else round(float(sigma), 6)
