"""The files of a run that was cut off, made again from its log."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from PIL import Image

from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.files.disk import disk
from slam.files.graphs.file import read_graph
from slam.files.logs.read import RUN_LOG
from slam.files.tum import read_tum
from slam.run.experiment_setup import replay_experiment
from slam.scenario.file import load_scenario, read_scenario
from slam.scenario.schema import Scenario

_REPLAY: Final = "replay"


@dataclass(frozen=True, slots=True)
class Repair:
    """Names of the files of a run, by what became of each."""

    made: list[str]
    kept: list[str]
    missing: list[str]
    """Files that a log cannot give, or that this run did not have."""


def repair(folder: Path, console: Terminal, force: bool = False) -> Repair:
    """Run the log of a run through the method again, and put the files that are missing or damaged into its folder.

    What is whole is kept, but with ``force`` replaced. InputError without a log that holds a scan.
    """
    if not (folder / RUN_LOG).is_file():
        raise InputError(f"{folder}: has no {RUN_LOG}, from which all else is made; give the folder of a run")
    clear_drafts(folder)
    scenario = _settings(folder)
    with TemporaryDirectory(prefix=".draft-", dir=folder) as name:
        again = Path(name) / "run"
        replay_experiment(folder, scenario).run(again, console=console)
        (again / RUN_LOG).unlink(missing_ok=True)
        return _move_in(again, folder, force)


def clear_drafts(folder: Path) -> None:
    """Remove the drafts that a killed process has left here."""
    from shutil import rmtree

    for left in folder.glob(".draft-*"):
        rmtree(left) if left.is_dir() else left.unlink()


def _settings(folder: Path) -> Scenario:
    """The settings of the run; those of a replay where they are lost."""
    config = folder / "config.yaml"
    return read_scenario(config) if _is_whole(config) else load_scenario(_REPLAY)


def _move_in(again: Path, folder: Path, force: bool) -> Repair:
    found = sorted(path.name for path in again.iterdir())
    kept = [] if force else [name for name in found if _is_whole(folder / name)]
    made = [name for name in found if name not in kept]
    for name in made:
        disk().rename(again / name, folder / name)
    there = {path.name for path in folder.iterdir()}
    return Repair(made, kept, sorted(set(_CHECKS) - there))


def _is_whole(path: Path) -> bool:
    """Tell if a file is there and can be read to its end."""
    if not path.is_file():
        return False
    try:
        _CHECKS.get(path.name, Path.read_bytes)(path)
    except (OSError, ValueError, InputError):
        return False
    return True


def _read_json(path: Path) -> Any:
    return json.loads(path.read_bytes())


def _check_table(path: Path) -> None:
    first, *rows = path.read_bytes().splitlines(keepends=True)
    if any(row.count(b",") != first.count(b",") or not row.endswith(b"\n") for row in [first, *rows]):
        raise ValueError("a row is cut")


def _check_picture(path: Path) -> None:
    with Image.open(path) as picture:
        picture.load()


_CHECKS: Final[dict[str, Callable[[Path], object]]] = {
    "config.yaml": read_scenario,
    "trajectory.tum": read_tum,
    "odometry.tum": read_tum,
    "groundtruth.tum": read_tum,
    "closed.tum": read_tum,
    "steps.csv": _check_table,
    "lines.geojson": _read_json,
    "walls.geojson": _read_json,
    "metrics.json": _read_json,
    "map.json": _read_json,
    "graph.json": read_graph,
    "map.png": _check_picture,
    "errors.png": _check_picture,
}
"""Reads each file of a run to its end; raises where it cannot."""
