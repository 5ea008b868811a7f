"""A lost loop-closing process: the run reports it, continues without loops, and writes consistent files."""

import io
import json
import os
import pickle
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from slam.cli.main import app
from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.errors import BackEndLost, InputError
from slam.files.logs import read_log
from slam.graph import back_end_process
from slam.graph.loop_closing import STEPPED, Timing
from slam.line_slam import Estimate, LineSlam
from slam.odometry import Odometry, Twist2D
from slam.pose import stack_poses
from slam.robot import Observation
from slam.run.experiment import Experiment
from slam.run.experiment_setup import replay_experiment
from slam.run.optimize import Optimization
from slam.run.report.faults import faults
from slam.run.results.run_record import RunRecord
from slam.run.run import Run
from slam.run.run_and_report import run_and_report
from slam.run.step import Step
from slam.run.viewer.live_run import EventDetector
from slam.scan import LaserScan
from slam.scenario.file import load_scenario

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="finds processes in /proc")
KILLED = "the process that closes loops was killed by SIGKILL; is the memory full?"
SOON, LATE = 230, 350
"""Indices of scans: from the first one the process runs, from the second one it has closed loops."""


def back_ends() -> list[int]:
    """Numbers of the back ends that this process has started and that have not ended."""
    children: set[str] = set()
    for task in Path("/proc/self/task").iterdir():
        children.update((task / "children").read_text().split())
    return [int(child) for child in children if b"back_end_process" in _command(child)]


def _command(process: str) -> bytes:
    with suppress(OSError):
        return Path(f"/proc/{process}/cmdline").read_bytes()
    return b""


def end_back_end(number: int = signal.SIGKILL) -> None:
    (process,) = back_ends()
    os.kill(process, number)


def drive(log: Path, at: int | None, timing: Timing = STEPPED) -> tuple[LineSlam, list[Estimate]]:
    """Take all scans of a log; the back end is killed before scan ``at``."""
    recorded = read_log(log)
    slam = LineSlam(SlamConfig(), recorded.T_base_laser, timing=timing)
    estimates = []
    for k in range(len(recorded)):
        if k == at:
            end_back_end()
        estimates.append(slam.update(recorded.scan(k), recorded.odometry(k)))
    return slam, estimates


def with_loss(experiment: Experiment, at: int, end: Callable[[], None] = end_back_end) -> Experiment:
    """The experiment, whose back end is ended before scan ``at``."""
    slam = experiment.slam
    assert isinstance(slam, LineSlam)
    update = slam.update

    def update_then(scan: LaserScan, odometry: Odometry) -> Estimate:
        if slam.scans == at:
            end()
        return update(scan, odometry)

    slam.update = update_then  # type: ignore[method-assign]  # of this object alone
    return experiment


@pytest.fixture(scope="module")
def whole(lap_log: Path) -> tuple[LineSlam, list[Estimate]]:
    """A run whose back end is killed after the last scan."""
    run = drive(lap_log, None)
    end_back_end()
    return run


@pytest.fixture(scope="module")
def lost(lap_log: Path) -> tuple[LineSlam, list[Estimate]]:
    return drive(lap_log, LATE)


@pytest.fixture(scope="module")
def lost_run(lap_log: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lost") / "run"
    with_loss(replay_experiment(lap_log, load_scenario("replay")), LATE).run(folder, pictures=False)
    return folder


def test_the_front_end_continues_without_its_process(
    lost: tuple[LineSlam, list[Estimate]], whole: tuple[LineSlam, list[Estimate]]
) -> None:
    """Until the loss the estimates are those of a complete run; after it, every scan has a pose, but no loop closes."""
    slam, estimates = lost
    reported = [bool(estimate.back_end_lost) for estimate in estimates]
    first = reported.index(True)
    assert first >= LATE
    assert all(reported[first:])
    assert estimates[-1].back_end_lost == KILLED
    closed = [estimate.closure is not None for estimate in estimates]
    assert any(closed[:LATE])
    assert not any(closed[first:])
    poses, expected = (stack_poses(e.T_map_base for e in run[:LATE]) for run in (estimates, whole[1]))
    assert np.array_equal(poses, expected)
    local, expected = (stack_poses(e.T_local_base for e in run) for run in (estimates, whole[1]))
    np.testing.assert_allclose(local, expected, atol=0.05)
    assert estimates[-1].map_points > estimates[first].map_points
    with pytest.raises(BackEndLost, match=KILLED):
        slam.finish()


def test_a_real_time_run_continues_without_its_process(lap_log: Path) -> None:
    slam, estimates = drive(lap_log, SOON, Timing(real_time=True))
    assert all(estimate.closure is None for estimate in estimates)
    assert estimates[-1].back_end_lost == KILLED
    assert not back_ends()
    with pytest.raises(BackEndLost):
        slam.finish()


def test_a_process_lost_at_the_end_closes_no_loop(whole: tuple[LineSlam, list[Estimate]]) -> None:
    slam, _ = whole
    for _ in range(2):
        with pytest.raises(BackEndLost, match=KILLED):
            slam.finish()


def test_a_process_that_does_not_start_is_lost(lap_log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_process(*_: Any, **__: Any) -> None:
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr("slam.graph.back_end_process.subprocess.Popen", no_process)
    slam, estimates = drive(lap_log, None)
    assert estimates[-1].back_end_lost == "the process that closes loops cannot be started: Cannot allocate memory"
    with pytest.raises(BackEndLost):
        slam.finish()


def test_signals_to_the_process_group_end_only_the_loop(lap_log: Path) -> None:
    """Ctrl-C, ``timeout`` and a closed terminal also signal the back end. It ignores them, and closes the run."""

    def signal_all() -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
            end_back_end(number)

    recorded = read_log(lap_log)
    slam = LineSlam(SlamConfig(), recorded.T_base_laser)
    for k in range(len(recorded)):
        if k == LATE:
            signal_all()
        slam.update(recorded.scan(k), recorded.odometry(k))
    assert slam.finish() is not None


def test_truncated_results_are_dropped() -> None:
    """If the process dies while it writes, the complete results are received first, and then its end."""

    class Dead:
        def __init__(self, written: bytes) -> None:
            self.stdout = io.BytesIO(written)

        def wait(self) -> int:
            return -signal.SIGKILL

    results = [(np.arange(3.0), "first"), (np.arange(4.0), {"second": None})]
    written = [pickle.dumps(result, pickle.HIGHEST_PROTOCOL) for result in results]
    whole = b"".join(written)
    for length in range(len(whole) + 1):
        queue: SimpleQueue[Any] = SimpleQueue()
        back_end_process._receive(Dead(whole[:length]), queue)
        got = [queue.get() for _ in range(queue.qsize())]
        assert got.pop().how == "was killed by SIGKILL; is the memory full?"
        assert len(got) == (length >= len(written[0])) + (length >= len(whole))


@pytest.mark.parametrize(
    ("code", "how"),
    [(0, "ended with exit code 0"), (3, "ended with exit code 3"), (-signal.SIGSEGV, "was killed by SIGSEGV")],
)
def test_the_end_of_the_process_is_described(code: int, how: str) -> None:
    assert back_end_process._Ended(code).how == how


def test_a_run_without_its_back_end_has_no_files_of_a_closed_map(lost_run: Path) -> None:
    record = RunRecord.open(lost_run)
    assert record.metrics is not None
    assert record.metrics["back_end_lost"].startswith(f"{KILLED}; no loop is closed from scan ")
    assert record.metrics["ending"] == "no more scans"
    assert not {"loops", "loops_believed", "closing_s"} & record.metrics.keys()
    for name in ("closed.tum", "graph.json", "key_scans.npz", "walls.geojson"):
        assert not (lost_run / name).exists()
    assert record.traces.closed is None
    assert len(record.traces.stamps) == len(read_log(lost_run / "log.mcap"))
    assert record.saved_map is not None
    (fault,) = [fault for fault in faults(record, record.metrics) if "closes loops" in fault]
    assert fault.endswith("the results are those estimated during the run; try hopslam optimize.")


def test_report_and_export_accept_a_run_without_back_end(lost_run: Path, tmp_path: Path) -> None:
    for words in (
        ["report", "--out", str(tmp_path / "page.html")],
        ["export", "--to", "tum", "--out", str(tmp_path / "a")],
    ):
        result = CliRunner().invoke(app, [words[0], str(lost_run), *words[1:]])
        assert result.exit_code == 0, result.output
    assert "was killed by SIGKILL" in (tmp_path / "page.html").read_text()
    result = CliRunner().invoke(app, ["export", str(lost_run), "--to", "g2o", "--out", str(tmp_path / "g")])
    assert isinstance(result.exception, InputError)


def test_optimize_closes_a_run_that_lost_its_back_end(lost_run: Path, tmp_path: Path) -> None:
    record = RunRecord.open(lost_run)
    folder, metrics = Optimization(record, record.config).run(tmp_path / "run", Terminal(quiet=True))
    assert RunRecord.open(folder).traces.closed is not None
    assert metrics["loops_believed"] > 0
    assert "back_end_lost" not in metrics
    assert "back_end_lost" not in json.loads((folder / "metrics.json").read_text())


def test_a_lost_back_end_is_one_line_and_the_run_succeeds(
    lap_log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    experiment = with_loss(replay_experiment(lap_log, load_scenario("replay")), SOON)
    console = Terminal()
    run_and_report(lambda viewers: Run.of(experiment.run(tmp_path / "run", viewers, console), None), None, console)
    error = capfd.readouterr().err.strip()
    assert error.startswith(f"hopslam: warning: {KILLED}; no loop is closed from scan ")
    assert error.endswith(f"hopslam optimize {tmp_path / 'run'}")
    assert "\n" not in error


def test_a_lost_back_end_is_reported_once(lap_log: Path, lost: tuple[LineSlam, list[Estimate]]) -> None:
    recorded, (_, estimates), detector = read_log(lap_log), lost, EventDetector()
    steps = [
        Step(k, Observation(recorded.scan(k), recorded.odometry(k)), estimate, Twist2D(), 0.0)
        for k, estimate in enumerate(estimates)
    ]
    reported = [event for step in steps for event in detector.detect(step) if "closes loops" in event.text]
    assert [(event.level, event.text) for event in reported] == [("WARN", KILLED)]
