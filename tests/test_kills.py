"""Commands are killed at random moments: other commands read what is left or name what is missing."""

import os
import random
import signal
import sys
from collections import Counter
from pathlib import Path
from shutil import copytree, rmtree
from time import perf_counter, sleep

import pytest

from slam.cli.main import main
from slam.errors import InputError
from slam.run.experiment_setup import replay_experiment
from slam.scenario.file import load_scenario
from slam.sweep.folder import Folder
from slam.sweep.result_store import ResultStore
from tests.killed_commands import children_of, end, is_running, logged_stamps, result_of, start

MOMENTS = 20
SCANS = 60
LOST = 1.0
"""Seconds of a killed run that may be lost."""
SWEEP = "sweep run corridor --set duration=1 --seeds 0:3 --jobs 2 --out {here}/sweep"
KILLED = {
    "run": "run corridor --set duration=8 --out {here}/run",
    "replay": "replay {small}/small.log --out {here}/run",
    "localize": "localize {small}/small.log --map {small}/run/map.json --out {here}/run",
    "optimize": "optimize {here}/run",
    "repair": "repair {here}/run --force",
    "report": "report {here}/run",
    "animate": "animate {here}/run --seconds 1 --width 200",
}
GROWING = ("run", "replay", "localize")
"""Commands that write a log scan by scan."""
AFTERWARDS = {
    "report": "report {here}/run --out {here}/after.html",
    "export": "export {here}/run --to csv --out {here}/after.csv --force",
    "animate": "animate {here}/run --seconds 1 --width 200 --out {here}/after.webp",
    "eval": "eval {here}/run --reference {here}/run/trajectory.tum",
    "optimize": "optimize {here}/run --out {here}/optimized",
    "repair": "repair {here}/run",
    "report again": "report {here}/run --out {here}/again.html",
    "export again": "export {here}/run --to tum --out {here}/again.tum",
}
SAMPLE = ["report", "repair", "report again", "export again"]


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory, lap_log: Path) -> Path:
    """A small log and its run."""
    folder = tmp_path_factory.mktemp("small")
    log = folder / "small.log"
    log.write_text("".join(lap_log.read_text().splitlines(keepends=True)[:SCANS]))
    replay_experiment(log, load_scenario("replay")).run(folder / "run")
    return folder


@pytest.fixture
def is_sample(pytestconfig: pytest.Config) -> bool:
    """True where only one moment of one command is tried."""
    return not pytestconfig.getoption("--all-faults")


def call(command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> tuple[int, list[str]]:
    """Exit code of a command in this process, and its lines on standard error that are not warnings."""
    monkeypatch.setattr(sys, "argv", ["hopslam", *command.split()])
    with pytest.raises(SystemExit) as left:
        main()
    said = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("hopslam: warning: ")]
    return int(left.value.code or 0), said


def prepared(name: str, folder: Path, small: Path) -> list[str]:
    """A new folder for a command, and its words."""
    folder.mkdir()
    if name not in GROWING:
        copytree(small / "run", folder / "run")
    return KILLED[name].format(here=folder, small=small).split()


def seconds_of(name: str, folder: Path, small: Path) -> float:
    """Return the duration of a command that is not killed; for one that writes a log, from its first scan on."""
    started = start(prepared(name, folder, small))
    while name in GROWING and not (folder / "run" / "log.mcap").is_file() and is_running(started.child):
        sleep(0.001)
    began = perf_counter()
    assert result_of(started) == 0
    return perf_counter() - began


def require_usable(name: str, codes: dict[str, int], folder: Path) -> None:
    """Check that results written before the kill exist, and that a repaired run is complete."""
    if not codes["repair"]:
        assert not codes["report again"]
        assert not codes["export again"]
        assert (folder / "run" / "metrics.json").is_file()
        assert not list(folder.rglob(".draft-*"))
        assert not list(folder.rglob(".ready"))
    if name not in GROWING:
        assert not any(codes.values()), codes


@pytest.mark.parametrize("name", KILLED)
def test_commands_read_the_files_of_a_killed_command(
    name: str,
    is_sample: bool,
    small: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if is_sample and name != "replay":
        pytest.skip("takes minutes; make test-all runs it")
    moments, afterwards = (1, SAMPLE) if is_sample else (MOMENTS, list(AFTERWARDS))
    whole = seconds_of(name, tmp_path / "whole", small)
    chance, table, lost = random.Random(name), Counter[str](), [0.0]
    for moment in range(moments):
        folder = tmp_path / f"{moment}"
        log = folder / "run" / "log.mcap"
        begun = (
            log if name in GROWING and moment % 5 != 4 else None
        )  # every fifth run is killed even before its log begins
        seen = end(start(prepared(name, folder, small)), chance.uniform(0.0, whole), begun)
        if seen:
            lost.append(seen[-1] - max([seen[0] - 0.1, *logged_stamps(log)]))
            assert lost[-1] <= LOST
        codes = {}
        for after in afterwards:
            code, said = call(AFTERWARDS[after].format(here=folder), monkeypatch, capsys)
            assert len(said) == (code != 0), (after, code, said)
            assert code in (0, InputError.exit_code), (after, code, said)
            codes[after] = code
            table[f"{after}: {said[0].replace(str(folder), '') if code else 'works'}"] += 1
        if seen and len(seen) > LOST / 0.1:
            refused = {after for after, code in codes.items() if code}
            assert refused == ({"optimize"} if name == "localize" and not is_sample else set())
        require_usable(name, codes, folder)
        rmtree(folder)
    print(f"\n{name}, killed {moments} times within {whole:.1f} s; at most {max(lost):.1f} s of scans lost")
    print(*sorted(f"{n:4} {what}" for what, n in table.items()), sep="\n")


@pytest.mark.parametrize("whom", ["worker", "driver"])
def test_a_sweep_completes_whichever_process_is_killed(
    whom: str, is_sample: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if is_sample:
        pytest.skip("takes minutes; make test-all runs it")
    chance, table = random.Random(whom), Counter[str]()
    began = perf_counter()
    assert result_of(start(SWEEP.format(here=tmp_path / "whole").split())) == 0
    whole = perf_counter() - began
    for moment in range(MOMENTS):
        here = tmp_path / f"{moment}"
        started = start(SWEEP.format(here=here).split())
        sleep(chance.uniform(0.0, whole))
        if whom == "driver":
            end(started, 0.0)
        else:
            workers = children_of(started.child) if is_running(started.child) else []
            if workers:
                os.kill(chance.choice(workers), signal.SIGKILL)
            assert result_of(started) == 0
            table["a worker was killed" if workers else "no worker was running"] += 1
        code, said = call(SWEEP.format(here=here), monkeypatch, capsys)
        assert (code, said) == (0, [])
        rows = list(ResultStore(Folder(str(here / "sweep"))).rows())
        assert [row["status"] for row in rows] == ["done"] * 3
        assert not list(here.rglob(".draft-*"))
        for row in rows:
            assert call(f"report {here}/sweep/runs/{row['id']}", monkeypatch, capsys) == (0, [])
        assert call(f"sweep report {here}/sweep", monkeypatch, capsys) == (0, [])
        rmtree(here)
    print(f"\nsweep, its {whom} killed {MOMENTS} times within {whole:.1f} s", *table.items(), sep="\n")
