"""Each call that changes a file fails once: the failure is reported and all files stay readable."""

import errno
import json
import random
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from shutil import copytree, rmtree

import pytest

from slam.cli.bench import print_tables
from slam.cli.main import main
from slam.errors import InputError, StorageError
from slam.files.disk import using_disk
from slam.files.tum import read_tum
from slam.run.experiment_setup import replay_experiment
from slam.run.export.formats import export
from slam.run.report.page import write_report
from slam.run.results.run_record import RunRecord
from slam.scenario.file import load_scenario
from slam.sweep import sweep
from slam.sweep.executor import FinishedJob, LostJob
from slam.sweep.job import Job
from slam.sweep.run_job import run_job
from tests.faulty_disk import FaultyDisk

FAULTS = (errno.ENOSPC, errno.EIO, errno.EPIPE, None)
SCANS = 4
SHORT = "--set duration=0.15"
COMMANDS = {
    "run": f"run corridor {SHORT} --out {{here}}/run",
    "replay": "replay {run}/../small.log --out {here}/run",
    "localize": "localize {run}/../small.log --map {run}/map.json --out {here}/run",
    "optimize": "optimize {here}/run",
    "repair": "repair {here}/run --force",
    "sweep": f"sweep run corridor {SHORT} --seeds 0:1 --jobs 1 --retry 1 --out {{here}}/sweep",
    "report": "report {run} --out {here}/report.html",
    "animate": "animate {run} --seconds 1 --width 200 --out {here}/map.webp",
    **{f"export {form}": f"export {{run}} --to {form} --out {{here}}/out.{form}" for form in
       ("tum", "csv", "geojson", "svg", "dxf", "carmen", "mcap", "g2o", "ros", "rosbag2")},
}  # fmt: skip
CHANGING = ("optimize", "repair")
"""Commands that change the run that they are given."""


class OwnProcess:
    """An executor of a sweep's jobs in this process, where their disk can be made to fail."""

    def __init__(self, size: int, runs: str, pictures: bool, allowed: tuple[str, ...] = ()) -> None:
        self._arguments, self._jobs = (runs, pictures, allowed), list[Job]()

    @property
    def free(self) -> int:
        return 1 - len(self._jobs)

    @property
    def busy(self) -> int:
        return len(self._jobs)

    def submit(self, job: Job) -> None:
        self._jobs.append(job)

    def collect(self, timeout: float) -> Iterator[FinishedJob | LostJob]:
        job = self._jobs.pop()
        row = run_job(job, *self._arguments)
        yield LostJob(job, "interrupted") if row is None else FinishedJob(job, row)

    def close(self) -> None:
        self._jobs.clear()


@pytest.fixture(scope="module")
def small_run(tmp_path_factory: pytest.TempPathFactory, lap_log: Path) -> Path:
    """A run of the first scans of the way around a block."""
    folder = tmp_path_factory.mktemp("small")
    log = folder / "small.log"
    log.write_text("".join(lap_log.read_text().splitlines(keepends=True)[:SCANS]))
    replay_experiment(log, load_scenario("replay")).run(folder / "run")
    return folder / "run"


def every_fault(points: int) -> list[tuple[int, int | None, bool]]:
    """Return every fault: the number of the call that fails, its error, and whether all later calls fail too."""
    once = [(at, fault, False) for at in range(points) for fault in FAULTS]
    return once + [(at, errno.ENOSPC, True) for at in range(points)]


def one_fault(name: str) -> list[tuple[int, int | None, bool]]:
    """Draw a fault with the name as the seed: more often at an early call, possibly after the last call."""
    chance = random.Random(name)
    return [(int(50 ** chance.random()), chance.choice(FAULTS[:3]), chance.random() < 0.3)]


@pytest.mark.parametrize("name", COMMANDS)
def test_a_failed_write_is_reported_and_files_stay_readable(
    name: str,
    small_run: Path,
    tmp_path: Path,
    pytestconfig: pytest.Config,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(sweep, "ProcessPool", OwnProcess)

    def run_once(folder: Path, disk: FaultyDisk) -> tuple[int, list[str]]:
        folder.mkdir()
        if name in CHANGING:
            copytree(small_run, folder / "run")
        words = COMMANDS[name].format(run=small_run, here=folder).split()
        monkeypatch.setattr(sys, "argv", ["hopslam", *words])
        with using_disk(disk), pytest.raises(SystemExit) as left:
            main()
        return int(left.value.code or 0), capsys.readouterr().err.splitlines()

    cases = one_fault(name)
    if pytestconfig.getoption("--all-faults"):
        whole = FaultyDisk()
        assert run_once(tmp_path / "whole", whole) == (0, [])
        cases = every_fault(len(whole.calls))
    failed = []
    for at, fault, forever in cases:
        folder, disk = tmp_path / "faulty", FaultyDisk(at, fault, forever)
        try:
            code, said = run_once(folder, disk)
            is_survived = fault is None or len(disk.calls) <= at or (name == "sweep" and not forever)
            require_one_line(code, said, is_survived)
            require_readable(folder)
        except AssertionError as error:
            failed.append(f"{disk.calls[at : at + 1]} ({at}), {fault}, {forever}: {error}")
        rmtree(folder)
    print(f"{name}: {len(failed)} of {len(cases)} faults failed", *failed, sep="\n")
    assert not failed


@pytest.mark.parametrize("fault", [errno.ENOSPC, errno.EIO])
def test_a_failed_write_of_a_benchmark_table_is_reported(tmp_path: Path, fault: int) -> None:
    path = tmp_path / "tables.md"
    with (
        using_disk(FaultyDisk(0, fault, forever=True)),
        pytest.raises(StorageError, match="cannot be written"),
    ):
        print_tables([], path)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="choose another --out FILE"):
        print_tables([], tmp_path / "nowhere" / "tables.md")


def require_one_line(code: int, said: list[str], is_survived: bool) -> None:
    """Check that a command which failed printed one line, and one that succeeded none.

    It may succeed only if it survives the fault, as a sweep does by trying the run again.
    """
    if is_survived and not code:
        assert not said, said
        return
    assert code == StorageError.exit_code, (code, said)
    assert len(said) == 1, said
    assert said[0].startswith("hopslam: /"), said
    assert ".draft-" not in said[0], said


def require_readable(folder: Path) -> None:
    assert not list(folder.rglob(".draft-*")), list(folder.rglob("*"))
    for path in folder.rglob("*json"):
        json.loads(path.read_text())
    for path in folder.rglob("*.tum"):
        if path.stat().st_size:
            read_tum(path)
    with suppress(InputError):  # before the first scan there is no run to report
        record = RunRecord.open(folder / "run")
        write_report([record], folder / "after.html")
        export(record, "geojson", folder / "after.geojson")
