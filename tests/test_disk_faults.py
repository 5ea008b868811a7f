"""Every call that changes a file fails once: what is left is whole, and our own commands read it."""

import errno
import json
import random
import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress
from pathlib import Path
from shutil import copytree, rmtree

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from faulty_disk import FaultyDisk

from slam.console.terminal import Terminal
from slam.errors import InputError, StorageError
from slam.files.disk import using_disk
from slam.files.tum import read_tum
from slam.run.experiment_setup import replay_experiment
from slam.run.export.formats import export
from slam.run.optimize import Optimization
from slam.run.repair import repair
from slam.run.report.page import write_report
from slam.run.results.run_record import RunRecord
from slam.scenario.file import load_scenario

FAULTS = (errno.ENOSPC, errno.EIO, errno.EPIPE, None)
SAMPLE = 3
QUIET = Terminal(quiet=True)
Command = Callable[[Path, Path], object]


def replay(log: Path, folder: Path) -> None:
    replay_experiment(log, load_scenario("replay")).run(folder / "run", pictures=False)


def report(run: Path, folder: Path) -> None:
    write_report([RunRecord.open(run)], folder / "report.html")


def optimize(run: Path, folder: Path) -> None:
    record = RunRecord.open(copytree(run, folder / "run"))
    Optimization(record, record.config).run(None, QUIET)


def mend(run: Path, folder: Path) -> None:
    copytree(run, folder / "run")
    (folder / "run" / "metrics.json").unlink()
    repair(folder / "run", QUIET)


def exported(form: str) -> Command:
    return lambda run, folder: export(RunRecord.open(run), form, folder / form)


COMMANDS: dict[str, Command] = {
    "replay": replay,
    "report": report,
    "optimize": optimize,
    "repair": mend,
    **{f"export {form}": exported(form) for form in ("tum", "csv", "geojson", "svg", "carmen", "mcap", "g2o", "ros")},
}


@pytest.fixture(scope="module")
def small_run(tmp_path_factory: pytest.TempPathFactory, lap_log: Path) -> Path:
    """A run of the first thirty scans of the way around a block."""
    folder = tmp_path_factory.mktemp("small")
    log = folder / "small.log"
    log.write_text("".join(lap_log.read_text().splitlines(keepends=True)[:30]))
    replay_experiment(log, load_scenario("replay")).run(folder / "run")
    return folder / "run"


def faults(points: int, everything: bool, name: str) -> Iterator[tuple[int, int | None, bool]]:
    """Number of the call, error and whether all later calls fail too."""
    every = [(at, fault, False) for at in range(points) for fault in FAULTS]
    every += [(at, errno.ENOSPC, True) for at in range(points)]
    yield from every if everything else random.Random(name).sample(every, min(SAMPLE, len(every)))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_failing_call_leaves_readable_files(
    name: str, small_run: Path, tmp_path: Path, pytestconfig: pytest.Config
) -> None:
    command, whole = COMMANDS[name], FaultyDisk()
    run_once(command, small_run, tmp_path / "whole", whole)
    tried = 0
    for at, fault, forever in faults(len(whole.calls), pytestconfig.getoption("--all-faults"), name):
        folder = tmp_path / "faulty"
        disk = FaultyDisk(at, fault, forever)
        with nullcontext() if fault is None else pytest.raises((StorageError, OSError)):
            run_once(command, small_run, folder, disk)
        require_readable(folder)
        rmtree(folder)
        tried += 1
    print(f"{name}: {tried} of {len(whole.calls) * (len(FAULTS) + 1)} faults at {len(whole.calls)} calls")


def run_once(command: Command, run: Path, folder: Path, disk: FaultyDisk) -> None:
    folder.mkdir()
    with using_disk(disk):
        command(run, folder)


def require_readable(folder: Path) -> None:
    assert not list(folder.rglob(".draft-*"))
    for path in folder.rglob("*json"):
        json.loads(path.read_text())
    for path in folder.rglob("*.tum"):
        if path.stat().st_size:
            read_tum(path)
    run = folder / "run"
    with suppress(InputError):  # before the first scan there is no run to report
        record = RunRecord.open(run)
        assert write_report([record], folder / "after.html") is None
        export(record, "geojson", folder / "after.geojson")
