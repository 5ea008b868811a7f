"""The map of lines as GeoJSON: a LineString for each wall, metres, map frame (not the globe's degrees)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from slam.files.whole_files import write_whole
from slam.run.results.run_record import RunRecord


def write(record: RunRecord, out: Path) -> None:
    """A FeatureCollection with members ``frame`` and ``unit``; each wall has its ``length``."""
    features = [
        {
            "type": "Feature",
            "geometry": {"type": "LineString", "coordinates": np.round(ends, 4).tolist()},
            "properties": {"wall": number, "length": round(float(np.linalg.norm(ends[1] - ends[0])), 4)},
        }
        for number, ends in enumerate(record.walls)
    ]
    members = {"type": "FeatureCollection", "frame": "map", "unit": "metre", "features": features}
    write_whole(out, json.dumps(members, indent=1) + "\n")
