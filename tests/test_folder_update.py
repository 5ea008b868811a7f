"""New files of a run folder replace the old ones together, whatever call fails."""

import errno
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from slam.console.terminal import Terminal
from slam.files.disk import using_disk
from slam.files.tum import read_tum
from slam.pose import compose_poses, relative_poses
from slam.run.optimize import Optimization
from slam.run.repair import repair
from slam.run.results.folder_update import READY, finish_update, folder_update
from slam.run.results.run_log import logged_observations
from slam.run.results.run_record import RunRecord
from slam.run.results.traces import carried_on
from slam.scenario.file import load_scenario
from tests.faulty_disk import FaultyDisk

OLD, NEW = {"a": "old", "b": "old", "gone": "old"}, {"a": "new", "b": "new", "c": "new"}


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def update(folder: Path) -> None:
    with folder_update(folder, outdated=["gone", "never there"]) as draft:
        draft.mkdir()
        (draft / "kept").symlink_to(folder / "a")
        for name, text in NEW.items():
            (draft / name).write_text(text)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in OLD.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_new_files_replace_the_old_files(folder: Path) -> None:
    update(folder)
    assert contents(folder) == NEW
    finish_update(folder)
    assert contents(folder) == NEW


@pytest.mark.parametrize("at", range(4))
def test_a_failed_rename_leaves_all_new_or_all_old_files(folder: Path, at: int) -> None:
    with using_disk(FaultyDisk(at, errno.EIO)), pytest.raises(OSError, match="Input/output"):
        update(folder)
    assert (folder / READY).exists() == (at > 0)
    finish_update(folder)
    assert contents(folder) == (NEW if at else OLD)


def test_a_block_that_fails_changes_nothing(folder: Path) -> None:
    def fail() -> None:
        with folder_update(folder) as draft:
            draft.mkdir()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert contents(folder) == OLD


def test_two_processes_may_finish_an_update(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with using_disk(FaultyDisk(1, errno.EIO)), pytest.raises(OSError, match="Input/output"):
        update(folder)
    listed = sorted((folder / READY).iterdir())
    finish_update(folder)
    with monkeypatch.context() as other:
        (folder / READY).mkdir()
        other.setattr(Path, "iterdir", lambda path: iter(listed))
        finish_update(folder)
    assert contents(folder) == NEW


@pytest.fixture
def killed_run(lap_run: Path, tmp_path: Path) -> Path:
    """A run that was killed: its log has three scans fewer than its other files, and nothing was closed."""
    folder = tmp_path / "run"
    folder.mkdir()
    log = (lap_run / "log.mcap").read_bytes()
    (folder / "log.mcap").write_bytes(log[: len(log) // 8])
    scans = sum(1 for _ in logged_observations(folder / "log.mcap"))
    assert scans > 20
    for name in ("trajectory.tum", "odometry.tum", "steps.csv"):
        lines = (lap_run / name).read_text().splitlines(keepends=True)
        (folder / name).write_text("".join(lines[: scans + 3 + (name == "steps.csv")]))
    lines = (lap_run / "lines.geojson").read_text().splitlines(keepends=True)
    (folder / "lines.geojson").write_text("".join(lines[: 2 * scans]))
    shutil.copy(lap_run / "config.yaml", folder)
    return folder


def optimize(folder: Path) -> None:
    Optimization(RunRecord.open(folder), load_scenario(folder / "config.yaml")).run(None, Terminal(quiet=True))


def test_missing_scans_of_a_killed_log_are_filled_in(killed_run: Path, tmp_path: Path) -> None:
    repaired = Path(shutil.copytree(killed_run, tmp_path / "repaired"))
    scans = len(RunRecord.open(killed_run).traces.stamps)
    done = repair(repaired, Terminal(quiet=True))
    assert {"trajectory.tum", "odometry.tum", "steps.csv"} <= set(done.kept)
    optimize(killed_run)
    for folder in (killed_run, repaired):
        stamps, poses = read_tum(folder / "closed.tum")
        assert len(stamps) == scans
        record = RunRecord.open(folder)
        motion = relative_poses(record.traces.estimate[-4], record.traces.estimate[-3:])
        assert poses[-3:] == pytest.approx(compose_poses(poses[-4], motion), abs=1e-5)
    assert json.loads((repaired / "metrics.json").read_text())["scans"] == scans


def test_files_shorter_than_the_log_are_rewritten(killed_run: Path) -> None:
    scans = sum(1 for _ in logged_observations(killed_run / "log.mcap"))
    path = killed_run / "odometry.tum"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[: scans - 5]))
    done = repair(killed_run, Terminal(quiet=True))
    assert {"trajectory.tum", "odometry.tum", "steps.csv", "lines.geojson"} <= set(done.made)
    assert len(RunRecord.open(killed_run).traces.stamps) == scans


def test_known_poses_stay_and_gaps_follow_odometry() -> None:
    stamps = 0.1 * np.arange(6)
    motion = np.column_stack([np.arange(6.0), np.zeros(6), np.full(6, np.pi / 2)])
    known, poses = stamps[[1, 2, 4]] + 1e-7, np.array([[5.0, 5.0, 0.0], [7.0, 7.0, 0.0], [9.0, 9.0, np.pi]])
    whole = carried_on(known, poses, stamps, motion)
    assert (whole[[1, 2, 4]] == poses).all()
    assert whole[0] == pytest.approx([5.0, 6.0, 0.0])  # one metre back, which is to the right of the motion's heading
    assert whole[3] == pytest.approx([7.0, 6.0, 0.0])
    assert whole[5] == pytest.approx([9.0, 10.0, np.pi])
