"""Refused and killed commands leave nothing behind, whatever the length of a name."""

import socket
from pathlib import Path

import pytest

from slam.errors import InputError
from slam.files.atomic_files import atomic_file, atomic_folder, clear_drafts, write_atomic
from slam.run.experiment_setup import replay_experiment
from slam.run.results.run_folder import make_run_folder
from slam.run.viewer.viewers import Viewers
from slam.scenario.file import load_scenario
from slam.sweep.folder import Folder

LONGEST = 255
"""Bytes of a file's name."""


def test_a_run_refused_for_its_port_leaves_no_folder(
    small_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    before = make_run_folder("before")
    experiment = replay_experiment(small_log, load_scenario("replay"))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with Viewers(f"serve={port}") as viewers, pytest.raises(InputError, match=str(port)):
            experiment.run(viewers=viewers)
    assert sorted(path.name for path in Path("runs").iterdir()) == [before.name, "latest"]
    assert Path("runs/latest").resolve() == before.resolve()


@pytest.mark.parametrize("name", ["a" * LONGEST, "ä" * (LONGEST // 2), "a" * (LONGEST - 4) + ".png", "." + "a" * 254])
def test_files_with_the_longest_names_are_written(tmp_path: Path, name: str) -> None:
    write_atomic(tmp_path / name, "whole")
    assert (tmp_path / name).read_text() == "whole"
    with atomic_folder(tmp_path / f"{name[:-1]}b") as draft:
        draft.mkdir()
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("name", ["a" * 1000, "ä" * 1000])
def test_runs_of_long_scenario_names_have_a_folder(tmp_path: Path, name: str) -> None:
    folder = make_run_folder(name, runs=tmp_path)
    assert folder.name.startswith(name[:90])
    with pytest.raises(InputError, match="choose another --out"):
        make_run_folder("a", tmp_path / name)


def test_a_failed_block_keeps_the_old_file_and_no_draft(tmp_path: Path) -> None:
    write_atomic(tmp_path / "a", "old")
    with pytest.raises(ZeroDivisionError):
        fail_in(tmp_path / "a")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_text() == "old"


def fail_in(path: Path) -> None:
    with atomic_file(path) as draft:
        draft.write_text("new")
        raise ZeroDivisionError


def leave_drafts(folder: Path) -> None:
    """Make the drafts that killed processes leave."""
    (folder / ".draft-1" / "run").mkdir(parents=True)
    (folder / ".draft-1" / "run" / "log.mcap").write_bytes(b"")
    (folder / ".draft-2.png").write_bytes(b"")
    (folder / "kept").write_bytes(b"")


def test_drafts_of_killed_processes_are_cleared(tmp_path: Path) -> None:
    for clear in (lambda: clear_drafts(tmp_path), Folder(str(tmp_path)).clear_drafts):
        leave_drafts(tmp_path)
        clear()
        assert [path.name for path in tmp_path.iterdir()] == ["kept"]
