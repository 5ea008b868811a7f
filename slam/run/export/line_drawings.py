"""The map of lines as GeoJSON, DXF and SVG; metres, map frame."""

import json
from pathlib import Path
from typing import Final

import numpy as np

from slam.files.atomic_files import atomic_file, line_feature, write_atomic
from slam.named_code import import_optional
from slam.run.results.run_record import RunRecord

_MARGIN: Final = 0.5
"""Metres around the drawing."""
_PIXELS: Final = 1200.0
"""Length of the longer side, for viewers that need one; the picture scales freely."""
_PAGE: Final = """\
<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" \
viewBox="{left:.3f} {top:.3f} {w:.3f} {h:.3f}">
<rect x="{left:.3f}" y="{top:.3f}" width="{w:.3f}" height="{h:.3f}" fill="white"/>
<g transform="scale(1,-1)" fill="none" stroke-linecap="round">
<g id="walls" stroke="black" stroke-width="0.04">
{walls}
</g>
<polyline id="trajectory" stroke="#0072b2" stroke-width="0.03" points="{path}"/>
</g>
</svg>
"""


def write_geojson(record: RunRecord, out: Path) -> None:
    """Write a FeatureCollection with ``frame`` and ``unit``; a LineString for each wall, with its ``length``."""
    features = [
        line_feature(
            np.round(ends, 4).tolist(),
            {"wall": number, "length": round(float(np.linalg.norm(ends[1] - ends[0])), 4)},
        )
        for number, ends in enumerate(record.walls)
    ]
    members = {"type": "FeatureCollection", "frame": "map", "unit": "metre", "features": features}
    write_atomic(out, json.dumps(members, indent=1) + "\n")


def write_dxf(record: RunRecord, out: Path) -> None:
    """Write layer WALLS, and the robot's path on layer TRAJECTORY. InputError if ezdxf is not installed."""
    drawing = import_optional("ezdxf", "export").new("R2010", units=6)  # metres
    drawing.layers.add("WALLS", color=7)
    drawing.layers.add("TRAJECTORY", color=3)
    space = drawing.modelspace()
    for start, end in record.walls.tolist():
        space.add_line(start, end, dxfattribs={"layer": "WALLS"})
    path = record.traces.final[:, :2].tolist()
    if len(path) > 1:
        space.add_lwpolyline(path, dxfattribs={"layer": "TRAJECTORY"})
    with atomic_file(out) as draft:
        drawing.saveas(draft)


def write_svg(record: RunRecord, out: Path) -> None:
    """Write a picture in which one user unit is a metre, y up, walls black and the robot's path blue."""
    walls, path = record.walls, record.traces.final[:, :2]
    corners = np.concatenate([walls.reshape(-1, 2), path])
    low, high = corners.min(axis=0) - _MARGIN, corners.max(axis=0) + _MARGIN
    (w, h), scale = high - low, _PIXELS / (high - low).max()
    size = {"width": w * scale, "height": h * scale, "left": low[0], "top": -high[1], "w": w, "h": h}
    lines = (f'<line x1="{a:.3f}" y1="{b:.3f}" x2="{c:.3f}" y2="{d:.3f}"/>' for (a, b), (c, d) in walls.tolist())
    points = (f"{x:.3f},{y:.3f}" for x, y in path.tolist())
    write_atomic(out, _PAGE.format(**size, walls="\n".join(lines), path=" ".join(points)))
