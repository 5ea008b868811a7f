"""Makes the missing files of an interrupted run again, from its log."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from PIL import Image

from slam.console.terminal import Terminal
from slam.errors import InputError, StorageError
from slam.files.atomic_files import require_writable, write_atomic
from slam.files.disk import storage_error
from slam.files.graphs.file import read_graph
from slam.files.links import is_linked_file, link_file
from slam.files.logs.read import RUN_LOG
from slam.files.tum import read_tum, write_tum
from slam.run.experiment_setup import replay_experiment
from slam.run.results.folder_update import folder_update
from slam.run.results.metrics import measure
from slam.run.results.traces import carried_on
from slam.scenario.file import load_scenario, read_scenario
from slam.scenario.schema import Scenario

_REPLAY: Final = "replay"
_CAUSAL: Final = ("trajectory.tum", "odometry.tum", "groundtruth.tum", "steps.csv")
"""Files with a row for each scan, with the estimates at that time."""
_REMEDY: Final = "make room there, and repair it again"


@dataclass(frozen=True, slots=True)
class Repair:
    """Names of the files of a run, by their outcome."""

    made: list[str]
    kept: list[str]
    missing: list[str]
    """Files that cannot be made from a log, or that this run did not have."""


def repair(folder: Path, console: Terminal, force: bool = False) -> Repair:
    """Run the log of a run through the method again, and add the missing or damaged files to its folder.

    Intact files are kept, or replaced if ``force`` is True. Files that have a row for each scan are kept only together,
    and only if none of them has fewer scans than the log. InputError without a log that has a scan, StorageError if the
    files cannot be made.
    """
    if not (folder / RUN_LOG).is_file():
        raise InputError(f"{folder}: has no {RUN_LOG}, from which all else is made; give the folder of a run")
    with require_writable(folder, _REMEDY), folder_update(folder) as again:
        _run_again(folder, again, console)
        found = {path.name for path in again.iterdir()}
        kept = set() if force else _kept(folder, again, found)
        for name in kept:
            (again / name).unlink()
            link_file(folder / name, again / name)
        _fit_to_kept(again)
    there = {path.name for path in folder.iterdir()}
    return Repair(sorted(found - kept), sorted(kept), sorted(set(_CHECKS) - there))


def _run_again(folder: Path, again: Path, console: Terminal) -> None:
    """Run the log of a folder into another one without a log."""
    try:
        replay_experiment(folder, _settings(folder)).run(again, console=console)
    except StorageError as error:
        if isinstance(error.__cause__, OSError):  # it names a draft, which the user does not know
            raise storage_error(error.__cause__, folder, _REMEDY) from error
        raise
    (again / RUN_LOG).unlink(missing_ok=True)


def _settings(folder: Path) -> Scenario:
    """Return the settings of the run; those of a replay if they are lost."""
    config = folder / "config.yaml"
    return read_scenario(config) if _is_whole(config) else load_scenario(_REPLAY)


def _kept(folder: Path, again: Path, found: set[str]) -> set[str]:
    """Return the names of the intact files that are kept."""
    whole = {name for name in found if _is_whole(folder / name)}
    causal = found & set(_CAUSAL)
    if causal <= whole and _fewest_rows(folder, causal) >= _fewest_rows(again, causal):
        return whole
    return whole - {*_CAUSAL, "lines.geojson", "closed.tum"}


def _fewest_rows(folder: Path, names: set[str]) -> int:
    return min(((folder / name).read_bytes().count(b"\n") for name in names), default=0)


def _fit_to_kept(again: Path) -> None:
    """Extend the closed trajectory and the metrics to the scans of the kept files, if the log has fewer."""
    stamps, estimate = read_tum(again / "trajectory.tum")
    closed, measures = again / "closed.tum", again / "metrics.json"
    if closed.is_file() and not is_linked_file(closed):
        known, poses = read_tum(closed)
        if len(known) < len(stamps):
            write_tum(closed, stamps, carried_on(known, poses, stamps, estimate))
    if not is_linked_file(measures):
        metrics = json.loads(measures.read_text(encoding="utf-8")) | measure(again)
        write_atomic(measures, json.dumps(metrics, indent=2) + "\n")


def _is_whole(path: Path) -> bool:
    """Return True if a file exists and can be read to its end."""
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
"""Reads each file of a run to its end; raises if it cannot."""
