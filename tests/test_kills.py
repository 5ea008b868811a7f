"""Commands that end by SIGKILL at random moments: the others work on what is left, or say what is missing."""

import os
import random
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from shutil import copytree, rmtree

import pytest

from slam.cli.main import main
from slam.errors import InputError
from slam.run.experiment_setup import replay_experiment
from slam.scenario.file import load_scenario

MOMENTS = 20
SCANS = 12
KILLED = {
    "run": "run corridor --set duration=2 --out {here}/run",
    "replay": "replay {small}/small.log --out {here}/run",
    "localize": "localize {small}/small.log --map {small}/run/map.json --out {here}/run",
    "optimize": "optimize {here}/run",
    "repair": "repair {here}/run --force",
    "report": "report {here}/run",
    "animate": "animate {here}/run --seconds 1 --width 200",
}
CHANGING = ("optimize", "repair", "report", "animate")
"""Commands of a run that is there already."""
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


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory, lap_log: Path) -> Path:
    """A small log and its run."""
    folder = tmp_path_factory.mktemp("small")
    log = folder / "small.log"
    log.write_text("".join(lap_log.read_text().splitlines(keepends=True)[:SCANS]))
    replay_experiment(log, load_scenario("replay")).run(folder / "run")
    return folder


def start(words: list[str]) -> int:
    """Run a command in a child process, which has imported all that it needs; its number."""
    child = os.fork()
    if child:
        return child
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        sys.argv = ["hopslam", *words]
        main()
    finally:
        os._exit(0)


def kill_at(words: list[str], seconds: float) -> None:
    child = start(words)
    time.sleep(seconds)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def seconds_of(words: list[str]) -> float:
    began = time.perf_counter()
    os.waitpid(start(words), 0)
    return time.perf_counter() - began


@pytest.mark.parametrize("name", KILLED)
def test_commands_work_on_what_a_killed_one_leaves(
    name: str,
    small: Path,
    tmp_path: Path,
    pytestconfig: pytest.Config,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if not pytestconfig.getoption("--all-faults"):
        pytest.skip("takes minutes; make test-all runs it")

    def prepared(folder: Path, command: str) -> list[str]:
        folder.mkdir()
        if name in CHANGING:
            copytree(small / "run", folder / "run")
        return command.format(here=folder, small=small).split()

    def call(folder: Path, command: str) -> tuple[int, list[str]]:
        monkeypatch.setattr(sys, "argv", ["hopslam", *command.format(here=folder).split()])
        with pytest.raises(SystemExit) as left:
            main()
        said = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("hopslam: warning: ")]
        return int(left.value.code or 0), said

    whole = seconds_of(prepared(tmp_path / "whole", KILLED[name]))
    chance, table = random.Random(name), Counter[str]()
    for moment in range(MOMENTS):
        folder = tmp_path / f"{moment}"
        kill_at(prepared(folder, KILLED[name]), chance.uniform(0.0, whole))
        codes = {}
        for after, command in AFTERWARDS.items():
            code, said = call(folder, command)
            assert len(said) == (code != 0), (after, code, said)
            assert code in (0, InputError.exit_code), (after, code, said)
            codes[after] = code
            table[f"{after}: {said[0].replace(str(folder), '') if code else 'works'}"] += 1
        if not codes["repair"]:
            assert not codes["report again"]
            assert not codes["export again"]
            assert (folder / "run" / "metrics.json").is_file()
            assert not list(folder.rglob(".draft-*"))
        if name in CHANGING:
            assert not any(codes.values()), codes
        rmtree(folder)
    print(
        f"\n{name}, killed {MOMENTS} times within {whole:.1f} s",
        *sorted(f"{n:4} {what}" for what, n in table.items()),
        sep="\n",
    )
