"""Closed loops in the viewer: live, and of a finished run."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from slam.console.terminal import Terminal
from slam.graph.loop import Loop
from slam.pose import Pose2D
from slam.run.experiment_setup import replay_experiment
from slam.run.results.run_record import RunRecord
from slam.run.viewer.chunks import loop_chunks
from slam.run.viewer.finished_run import recording_of
from slam.run.viewer.loop_events import LoopsShown, closure_text
from slam.run.viewer.viewers import Viewers
from slam.scenario.file import load_scenario

RERUN = [sys.executable, "-m", "rerun_cli", "rrd", "print"]


def printed(recording: Path, entity: str, *options: str) -> str:
    command = [*RERUN, "--entity", entity, *options, str(recording)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout


def rows(recording: Path, entity: str) -> int:
    """Count the rows of an entity that have a time; those without one are colours and sizes."""
    lines = [
        line for line in printed(recording, entity).splitlines() if f" - {entity} - " in line and "radii" not in line
    ]
    return sum(int(line.split(" with ")[1].split(" rows")[0]) for line in lines)


@pytest.fixture(scope="module")
def live(lap_log: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that was recorded as it went."""
    folder = tmp_path_factory.mktemp("live")
    with Viewers([str(folder / "a.rrd")], Terminal(quiet=True)) as viewers:
        return replay_experiment(lap_log, load_scenario("replay")).run(folder / "run", viewers, pictures=False).folder


def test_path_and_loops_are_redrawn_at_closures(live: Path) -> None:
    closures = int((RunRecord.open(live).traces.steps["closure"] >= 0).sum())
    assert closures > 1
    for entity in ("/map/trajectory/closed", "/map/loops", "/map/loops/doubted"):
        assert rows(live / "run.rrd", entity) == closures + 1


def test_no_line_is_drawn_across_a_jump(live: Path) -> None:
    record = RunRecord.open(live)
    jumps = int((record.traces.steps["closure"] >= 0).sum())
    assert rows(live / "run.rrd", "/map/trajectory/slam") == len(record.traces.stamps) - 1 - jumps
    assert rows(live / "run.rrd", "/map/trajectory/odometry") == len(record.traces.stamps) - 1


def test_a_finished_run_reports_the_same_loops(live: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(live, tmp_path / "run", ignore=shutil.ignore_patterns("run.rrd"))
    finished = recording_of(copy, lambda scans, _: scans)
    live_texts, texts = (
        re.findall(
            r"\[((?:loop|all loops) closed.{50})", printed(recording, "/events", "-vvv")
        )  # rerun prints 100 characters
        for recording in (live / "run.rrd", finished)
    )
    assert texts == live_texts
    assert re.match(r"all loops closed at the end: (\d+) of \1 believed, the robot moved by", texts[-1])
    assert all(text.startswith("loop closed: submap ") for text in texts[:-1])
    assert rows(finished, "/map/loops") == rows(live / "run.rrd", "/map/loops")


def test_a_closure_is_described() -> None:
    loop = Loop(0, 41, 3, np.zeros(3), "odometry", 15, 14, 0.8, False, (), 900)
    text = "loop closed: submap 41 found in submap 3, 14 of 15 scans agree, map moved by 0.42 m"
    assert closure_text([loop], Pose2D(), Pose2D(0.42)) == text
    assert "agree, with 1 more, map moved" in closure_text([loop, loop], Pose2D(), Pose2D(0.42))
    assert closure_text([], Pose2D(), Pose2D(0.0, 2.0)) == "loop closed: map moved by 2.00 m"


def test_doubtful_loops_are_dashed_and_crossed_out() -> None:
    line, none = np.array([[[0.0, 0.0], [2.0, 0.0]]]), np.empty((0, 2, 2))
    for loops, doubted in ((line, none), (none, line), (none, none)):
        chunks = {chunk.entity: chunk for chunk in loop_chunks(0, 0.0, LoopsShown(np.empty((0, 2)), loops, doubted))}
        assert chunks.keys() == {"map/loops", "map/loops/doubted"}
