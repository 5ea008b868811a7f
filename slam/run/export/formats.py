"""The formats by name; the writer of a format is imported when it is used."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

from slam.errors import InputError
from slam.files.atomic_files import require_writable
from slam.named_code import import_by_name

if TYPE_CHECKING:
    from slam.run.results.run_record import RunRecord

Format = Literal["tum", "csv", "ros", "geojson", "dxf", "svg", "carmen", "mcap", "rosbag2", "g2o"]
FORMATS: Final[dict[Format, str]] = {
    "tum": "slam.run.export.trajectories:write_tum",
    "csv": "slam.run.export.trajectories:write_csv",
    "ros": "slam.run.export.ros_map:write_ros_map",
    "geojson": "slam.run.export.line_drawings:write_geojson",
    "dxf": "slam.run.export.line_drawings:write_dxf",
    "svg": "slam.run.export.line_drawings:write_svg",
    "carmen": "slam.run.export.carmen:write_carmen",
    "mcap": "slam.run.export.bags:write_mcap",
    "rosbag2": "slam.run.export.bags:write_rosbag2",
    "g2o": "slam.run.export.g2o:write_g2o",
}
"""Function that writes a RunRecord to a path, for each format."""


def export(record: RunRecord, to: str, out: Path, force: bool = False) -> None:
    """Write a run in that format to ``out``: a file, or a folder for ``ros`` and ``rosbag2``.

    InputError for an unknown format, for an existing path, and for data that the run does not have. With ``force`` an
    existing file is replaced; a folder never is.
    """
    if to not in FORMATS:
        raise InputError(f"--to {to}: no such format; there are {', '.join(FORMATS)}")
    if out.is_dir():
        raise InputError(f"{out}: a folder that is already there; choose another --out, or remove it")
    if out.exists() and not force:
        raise InputError(f"{out}: already there; add --force to replace it, or choose another --out")
    with require_writable(out, "choose another --out"):
        out.parent.mkdir(parents=True, exist_ok=True)
        import_by_name(FORMATS[to])(record, out)
