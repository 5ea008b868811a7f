"""The map of lines as DXF, for CAD: layer WALLS, and the way of the robot on layer TRAJECTORY."""

from __future__ import annotations

from pathlib import Path

from slam.files.whole_files import whole_file
from slam.named_code import import_optional
from slam.run.results.run_record import RunRecord


def write(record: RunRecord, out: Path) -> None:
    """Drawing units are metres, map frame. InputError where ezdxf is not installed."""
    drawing = import_optional("ezdxf", "export").new("R2010", units=6)  # metres
    drawing.layers.add("WALLS", color=7)
    drawing.layers.add("TRAJECTORY", color=3)
    space = drawing.modelspace()
    for start, end in record.walls.tolist():
        space.add_line(start, end, dxfattribs={"layer": "WALLS"})
    way = record.traces.estimate[:, :2].tolist()
    if len(way) > 1:
        space.add_lwpolyline(way, dxfattribs={"layer": "TRAJECTORY"})
    with whole_file(out) as draft:
        drawing.saveas(draft)
