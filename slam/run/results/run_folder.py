"""The folder of a run."""

import os
from datetime import datetime
from pathlib import Path
from typing import Final

from slam.errors import InputError
from slam.files.links import is_folder_link, link_folder

_LONGEST: Final = 200
"""Bytes of a scenario's name in the name of a folder; systems allow 255, and the time is added."""


def make_run_folder(name: str, out: Path | None = None, runs: Path = Path("runs")) -> Path:
    """Make a new folder for a run: ``out``, or ``runs/<name>-<time>`` with a link ``runs/latest`` to it.

    Raises InputError if ``out`` is not empty, or cannot be made.
    """
    try:
        return _given(out) if out else _stamped(name, runs)
    except OSError as error:
        problem = f"cannot make the run folder: {error.strerror}"
        raise InputError(f"{error.filename}: {problem}; choose another --out") from error


def _given(out: Path) -> Path:
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(f"{out}: already there and not empty; choose another --out, or remove it")
    out.mkdir(parents=True, exist_ok=True)
    return out


def _stamped(name: str, runs: Path) -> Path:
    runs.mkdir(parents=True, exist_ok=True)
    latest = runs / "latest"
    if latest.exists() and not is_folder_link(latest):
        raise InputError(f"{latest}: is not a link that could point at the new run; move it away, or give --out")
    folder = _first_free(runs / f"{shortened(name)}-{datetime.now():%Y%m%d-%H%M%S}")
    link_folder(latest, folder)
    return folder


def shortened(name: str) -> str:
    """Cut the name to the length of a folder's name, never inside a character."""
    return os.fsencode(name)[:_LONGEST].decode(errors="ignore")


def _first_free(wanted: Path) -> Path:
    """Make ``wanted``, or ``wanted-2``, ``-3`` ... if another run began in the same second."""
    folder, number = wanted, 1
    while True:
        try:
            folder.mkdir()
            return folder
        except FileExistsError:
            number += 1
            folder = wanted.with_name(f"{wanted.name}-{number}")
