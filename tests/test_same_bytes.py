"""The same seed gives the same bytes, whatever the threads, hash seed, locale, time zone or workers."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from slam.sweep.folder import Folder
from slam.sweep.result_store import ResultStore

RUN = ["run", "office_loop", "--set", "duration=3"]
STRANGE = {
    "PYTHONHASHSEED": "4711",
    "NUMBA_NUM_THREADS": "3",
    "OMP_NUM_THREADS": "3",
    "OPENBLAS_NUM_THREADS": "3",
    "LC_ALL": "tr_TR.UTF-8",
    "TZ": "Pacific/Chatham",
}
PLAIN = {name: "1" for name in STRANGE if name.endswith("THREADS")} | {
    "PYTHONHASHSEED": "0",
    "LC_ALL": "C",
    "TZ": "UTC",
}
TIMES = ("began", "real_time_factor", "closing_s", "slam_s_total")
"""Entries of metrics.json that depend on the machine and the moment, beside those in milliseconds."""
ROW_TIMES = ("seconds", "started", "host")
"""Entries of a row of a sweep that depend on the machine and the moment, beside those that begin with ``wall.``."""


def run(words: list[str], environment: dict[str, str]) -> None:
    command = [sys.executable, "-c", "from slam.cli.main import main; main()", *words]
    subprocess.run(
        command, env=os.environ | {"PYTHONPATH": str(Path.cwd())} | environment, check=True, capture_output=True
    )


def timeless(values: dict[str, Any], times: tuple[str, ...] = TIMES) -> dict[str, Any]:
    return {
        key: value
        for key, value in values.items()
        if key not in times and "_ms" not in key and not key.startswith("wall.")
    }


def contents(folder: Path) -> dict[str, object]:
    """Return the content of the files of a run, without times."""
    found: dict[str, object] = {path.name: path.read_bytes() for path in folder.iterdir()}
    found["metrics.json"] = timeless(json.loads((folder / "metrics.json").read_text()))
    with (folder / "steps.csv").open(newline="") as file:
        found["steps.csv"] = [timeless(row) for row in csv.DictReader(file)]
    return found


def require_same(folder: Path, other: Path) -> None:
    one, two = contents(folder), contents(other)
    assert sorted(one) == sorted(two)
    assert not [name for name in one if one[name] != two[name]]


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run in the plainest environment."""
    out = tmp_path_factory.mktemp("plain") / "run"
    run([*RUN, "--out", str(out)], PLAIN)
    return out


def test_unusual_environment_variables_change_no_byte(plain: Path, tmp_path: Path) -> None:
    run([*RUN, "--out", str(tmp_path / "run")], STRANGE)
    require_same(plain, tmp_path / "run")


@pytest.mark.parametrize("name", STRANGE)
def test_each_variable_alone_changes_no_byte(
    name: str, plain: Path, tmp_path: Path, pytestconfig: pytest.Config
) -> None:
    if not pytestconfig.getoption("--all-faults"):
        pytest.skip("takes a minute; make test-all runs it")
    run([*RUN, "--out", str(tmp_path / "run")], PLAIN | {name: STRANGE[name]})
    require_same(plain, tmp_path / "run")


def test_the_number_of_workers_changes_no_byte(tmp_path: Path, pytestconfig: pytest.Config) -> None:
    if not pytestconfig.getoption("--all-faults"):
        pytest.skip("takes a minute; make test-all runs it")
    for jobs in ("1", "3"):
        words = ["sweep", "run", "office_loop", "--set", "duration=3", "--seeds", "0:4", "--jobs", jobs, "--pictures"]
        run([*words, "--out", str(tmp_path / jobs)], {})
    one, three = (
        {row["id"]: timeless(row, ROW_TIMES) for row in ResultStore(Folder(str(tmp_path / jobs))).rows()}
        for jobs in ("1", "3")
    )
    assert len(one) == 4
    assert one == three
    for name in one:
        require_same(tmp_path / "1" / "runs" / name, tmp_path / "3" / "runs" / name)
