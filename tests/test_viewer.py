"""The rerun viewer: the contents of a recording, cut-off files, and missing viewers."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from slam.cli.main import app
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.line_slam import Estimate
from slam.lines.segments import Segments
from slam.matching.match import NO_MATCH
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.step import Step
from slam.run.viewer.broadcast import Broadcast
from slam.run.viewer.live_run import ODOMETRY_ONLY, EventDetector, RunViewer, coloured, frame_of
from slam.run.viewer.palette import NO_SEGMENT, wall_colours
from slam.run.viewer.scene import Scene
from slam.run.viewer.viewers import NO_DISPLAY, Target, Viewers, parse_target, parse_targets
from slam.scan import LaserScan

RERUN = [sys.executable, "-m", "rerun_cli"]
SCENE = Scene(Pose2D(0.1, 0.0, 0.0), outlines=(np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0]]),))
ENTITIES = {
    "/map/walls", "/map/robot", "/map/robot/body", "/map/scan", "/map/segments", "/map/points", "/map/lines",
    "/map/trajectory/slam", "/map/trajectory/odometry", "/map/trajectory/truth", "/events",
    *(f"/plots/{name}" for name in SCENE.plots),
}  # fmt: skip


def step(index: int, **observed: bool | tuple[bool, ...]) -> Step:
    scan = LaserScan(0.1 * index, -1.0, 0.1, 0.06, 4.0, np.full(21, 1.5))
    pose = Pose2D(0.05 * index, 0.0, 0.01 * index)
    observation = Observation(scan, Odometry(0.1 * index, pose), pose, **observed)
    return Step(index, observation, Estimate(0.1 * index, pose), Twist2D(0.5, 0.0), 0.0)


def show(steps: int, files: list[Path], urls: list[str]) -> list[str]:
    said: list[str] = []
    with Broadcast(files, urls, SCENE, said.append) as broadcast:
        viewer = RunViewer(broadcast, SCENE)
        for index in range(steps):
            viewer.on_step(step(index))
        viewer.end("arrived")
    return said


def rerun(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*RERUN, *map(str, arguments)], capture_output=True, text=True, timeout=60, check=False)


def entities(recording: Path) -> set[str]:
    """Return the entities that rerun's own reader finds in a recording."""
    lines = rerun("rrd", "print", recording).stdout.splitlines()
    return {line.split(" - ")[1] for line in lines if line.startswith("Chunk(")}


def rows(recording: Path, entity: str) -> int:
    lines = rerun("rrd", "print", "--entity", entity, recording).stdout.splitlines()
    return sum(int(line.split(" with ")[1].split(" rows")[0]) for line in lines if f" - {entity} - " in line)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of a run that was recorded."""
    folder = tmp_path_factory.mktemp("run")
    out, recording = folder / "out", folder / "a.rrd"
    settings = ["--set", "duration=3.0"]
    done = CliRunner().invoke(app, ["run", "corridor", "--out", str(out), "--rerun", str(recording), *settings])
    assert done.exit_code == 0, done.output
    return out


# --- what is asked for ---


@settings(max_examples=40)
@given(st.text(max_size=30))
def test_any_text_is_a_target_or_bad_input(text: str) -> None:
    if text.endswith(".rrd"):
        return  # would make the file
    with suppress(InputError):
        assert parse_target(text).kind in ("spawn", "connect", "serve")


def test_targets_are_read_as_users_write_them(tmp_path: Path) -> None:
    path = tmp_path / "a.rrd"
    assert parse_targets(["spawn", str(path), "spawn"]) == [Target("spawn"), Target("file", path=path.resolve())]
    assert parse_target("connect").url == "rerun+http://127.0.0.1:9876/proxy"
    assert parse_target("connect=pi").url == parse_target("connect=pi:9876").url == "rerun+http://pi:9876/proxy"
    assert parse_target("connect=rerun+http://pi:1234/proxy").url == "rerun+http://pi:1234/proxy"
    assert parse_target("serve=9200").port == 9200


@pytest.mark.parametrize("text", ["a.txt", "serve=x", "serve=70000", "connect=http://pi", "connect=pi:x", ""])
def test_an_invalid_target_is_bad_input(text: str) -> None:
    with pytest.raises(InputError, match="--rerun"):
        parse_target(text)


def test_without_a_target_rerun_is_not_even_imported() -> None:
    code = "import sys, slam.run.experiment, slam.run.run_and_report; sys.exit('rerun' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    assert Viewers().open(SCENE) is None


def test_no_screen_is_one_line_and_no_failure(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr("slam.run.viewer.rerun_program.is_listening", lambda url: False)
    with Viewers(["spawn"], Terminal()) as viewers:
        broadcast = viewers.open(SCENE)
        assert broadcast is not None
        with broadcast:
            RunViewer(broadcast, SCENE).on_step(step(0))
    assert capsys.readouterr().out.strip() == NO_DISPLAY


# --- what is shown ---


@given(st.floats(-10.0, 10.0))
def test_hues_follow_the_direction(angle: float) -> None:
    assert wall_colours(np.array([angle])) == wall_colours(np.array([angle + 2 * np.pi]))


def test_points_have_the_colour_of_their_segment() -> None:
    one = np.array([0.0])
    segments = Segments(np.array([2]), np.array([4]), one, one, np.zeros((1, 2)), np.ones((1, 2)))
    colours, ends, own = coloured(np.zeros((6, 2)), segments, Pose2D(1.0, 0.0, 0.0))
    assert colours.tolist() == [NO_SEGMENT] * 2 + own.tolist() * 3 + [NO_SEGMENT]
    assert_allclose(ends, [[[1.0, 0.0], [2.0, 1.0]]])


def test_a_frame_is_in_the_map_frame() -> None:
    seen = step(4)
    frame = frame_of(seen, Pose2D(1.0, 0.0, 0.0), SCENE.T_base_laser, deskew=False)
    laser = seen.estimate.T_map_base @ SCENE.T_base_laser
    assert_allclose(np.hypot(*(frame.points - laser.translation).T), 1.5)
    assert frame.odometry.x == pytest.approx(1.2)


def test_events_are_reported_once_and_at_their_end() -> None:
    detector = EventDetector()
    steps = [step(0), step(1, stalled=True), step(2, stalled=True), step(3), step(4, collided=True)]
    events = [(event.scan, event.level, event.text.split(":")[0]) for seen in steps for event in detector.detect(seen)]
    assert events == [
        (0, "INFO", "first scan"),
        (1, "WARN", "stalled"),
        (3, "INFO", "the wheels turn again"),
        (4, "ERROR", "collided"),
    ]


def test_odometry_alone_is_reported_only_at_updates() -> None:
    detector, texts = EventDetector(), []
    segments = Segments(*(np.zeros(0, np.int64) for _ in "12"), *(np.zeros(0) for _ in "12"), *2 * [np.zeros((0, 2))])
    for number, (matched, alone) in enumerate([(1, 0), (0, 0), (1, 1), (0, 0), (1, 1), (1, 0)]):
        match = replace(NO_MATCH, odometry_only=bool(alone))
        estimate = replace(step(number).estimate, segments=segments if matched else None, match=match)
        texts += [event.text for event in detector.detect(replace(step(number), estimate=estimate))]
    assert texts[1:] == [text for _, text in ODOMETRY_ONLY]


# --- recordings ---


def test_rerun_verifies_a_whole_recording(run: Path) -> None:
    recording = run / "run.rrd"
    assert rerun("rrd", "verify", recording, run.parent / "a.rrd").returncode == 0
    assert entities(recording) >= ENTITIES
    scans = len((run / "trajectory.tum").read_text().splitlines())
    assert rows(recording, "/map/scan") == scans + 2  # plus its style and its mount, once each
    assert recording.stat().st_size / scans < 20_000  # including static data


def test_view_creates_a_missing_recording(run: Path, tmp_path: Path) -> None:
    bare, out = tmp_path / "bare", tmp_path / "b.rrd"
    shutil.copytree(run, bare, ignore=shutil.ignore_patterns("run.rrd"))
    done = CliRunner().invoke(app, ["view", str(bare), "--rerun", str(out)])
    assert done.exit_code == 0, done.output
    assert rerun("rrd", "verify", out).returncode == 0
    assert entities(out) >= ENTITIES
    assert rows(out, "/map/scan") == rows(run / "run.rrd", "/map/scan")


def test_view_without_a_run_is_bad_input(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["view", str(tmp_path), "--rerun", str(tmp_path / "x.rrd")])
    assert isinstance(done.exception, InputError)


def test_a_truncated_recording_is_readable(tmp_path: Path) -> None:
    path = tmp_path / "cut.rrd"
    code = f"""
import os, time
from pathlib import Path
import sys
sys.path[:0] = [{str(Path(__file__).parent)!r}]
from test_viewer import SCENE, Broadcast, RunViewer, step
broadcast = Broadcast([Path({str(path)!r})], [], SCENE, print)
viewer = RunViewer(broadcast, SCENE)
for index in range(25):
    viewer.on_step(step(index))
    time.sleep(0.1)
os.kill(os.getpid(), 9)
"""
    killed = subprocess.run(
        [sys.executable, "-c", code],
        timeout=60,
        check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert killed.returncode == -9
    assert 25 - (rows(path, "/map/scan") - 2) <= 10  # a second of scans


# --- live ---


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def test_a_missing_viewer_is_reported_once() -> None:
    said = show(80, [], [f"rerun+http://127.0.0.1:{free_port()}/proxy"])
    assert len(said) == 1
    assert "no viewer" in said[0]


def test_a_viewer_that_never_reads_does_not_block_the_run() -> None:
    with socket.create_server(("127.0.0.1", 0)) as deaf:
        port = deaf.getsockname()[1]
        with Broadcast([], [f"rerun+http://127.0.0.1:{port}/proxy"], SCENE, lambda text: None) as broadcast:
            viewer = RunViewer(broadcast, SCENE)
            for index in range(200):
                viewer.on_step(step(index))
