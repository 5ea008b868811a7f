"""The formats by name; the module of each is imported when it is asked for."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Final

from slam.errors import InputError, StorageError
from slam.run.results.run_record import RunRecord

_FORMATS: Final = {
    "tum": "slam.run.export.tum",
    "csv": "slam.run.export.csv_table",
    "ros": "slam.run.export.ros_map",
    "geojson": "slam.run.export.geojson",
    "dxf": "slam.run.export.dxf",
    "svg": "slam.run.export.svg",
    "carmen": "slam.run.export.carmen",
    "mcap": "slam.run.export.mcap_file",
    "rosbag2": "slam.run.export.rosbag2",
}


def export(record: RunRecord, to: str, out: Path, force: bool = False) -> None:
    """Write a run in that format to ``out``: a file, or a folder for ``ros`` and ``rosbag2``.

    InputError for an unknown format, for what is already there, and for what the run does not have. With ``force`` a
    file that is already there is replaced; a folder never is.
    """
    if to not in _FORMATS:
        raise InputError(f"--to {to}: no such format; there are {', '.join(_FORMATS)}")
    if out.is_dir():
        raise InputError(f"{out}: a folder that is already there; choose another --out, or remove it")
    if out.exists() and not force:
        raise InputError(f"{out}: already there; add --force to replace it, or choose another --out")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        import_module(_FORMATS[to]).write(record, out)
    except OSError as error:
        raise StorageError(f"{out}: cannot be written: {error.strerror or error}; choose another --out") from error
