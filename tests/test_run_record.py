"""The recorded log of a run, and the run folder read back."""

from pathlib import Path

import numpy as np
import pytest

from slam.errors import InputError
from slam.line_slam import Estimate
from slam.matching.match import Match
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.experiment import Experiment
from slam.run.experiment_setup import replay_experiment
from slam.run.results.recorder import Recorder
from slam.run.results.run_log import RunLog, logged_mount, logged_observations
from slam.run.results.run_record import RunRecord
from slam.run.step import Step
from slam.scan import LaserScan
from slam.scenario.file import load_scenario

MOUNT = Pose2D(0.16, 0.01, 0.1)
COVARIANCE = np.array([[4.0, 0.5, 0.25], [0.5, 3.0, 0.125], [0.25, 0.125, 2.0]])


def observation(k: int) -> Observation:
    ranges = np.round(np.random.default_rng(k).uniform(0.1, 4.0, 300), 3)  # whole millimetres
    ranges[:3] = np.inf, -np.inf, np.nan
    scan = LaserScan(0.1 * k, -2.0, 0.0125, 0.0625, 4.0, ranges, 0.0001220703125, 0.125)
    return Observation(scan, Odometry(0.1 * k, Pose2D(k, -k, 0.5), Twist2D(0.5, -0.25)), Pose2D(0.1 * k, 0.2, -3.0))


def step(k: int) -> Step:
    estimate = Estimate(0.1 * k, Pose2D(k, 0.5, 1.0), match=Match(Pose2D(), 1, True, 1.0, covariance=COVARIANCE))
    return Step(k, observation(k), estimate, Twist2D(), 0.0)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    writer = RunLog(tmp_path, MOUNT)
    for k in range(50):
        writer.on_step(step(k))
    writer.close()
    return tmp_path / "log.mcap"


def assert_same(read: Observation, written: Observation) -> None:
    assert read.scan.stamp == pytest.approx(written.scan.stamp, abs=1e-9)
    np.testing.assert_array_equal(read.scan.ranges, written.scan.ranges)
    for name in ("angle_min", "angle_increment", "range_min", "range_max", "time_increment", "scan_time"):
        assert getattr(read.scan, name) == pytest.approx(getattr(written.scan, name), rel=1e-7)
    assert read.odometry.twist == written.odometry.twist
    for a, b in ((read.odometry.T_odom_base, written.odometry.T_odom_base), (read.T_map_base, written.T_map_base)):
        assert a is not None
        assert b is not None
        assert (a.x, a.y, a.theta) == pytest.approx((b.x, b.y, b.theta), abs=1e-12)


def test_a_recorded_run_is_read_back(log: Path) -> None:
    read = list(logged_observations(log))
    assert len(read) == 50
    for k, seen in enumerate(read):
        assert_same(seen, observation(k))
    mount = logged_mount(log)
    assert (mount.x, mount.y, mount.theta) == pytest.approx((MOUNT.x, MOUNT.y, MOUNT.theta), abs=1e-12)


def test_a_truncated_log_is_read_up_to_its_end(log: Path) -> None:
    whole, counts = log.read_bytes(), []
    for length in range(0, len(whole), 1009):
        log.write_bytes(whole[:length])
        read = list(logged_observations(log))
        counts.append(len(read))
        for k, seen in enumerate(read[-1:], len(read) - 1):
            assert_same(seen, observation(k))
    assert counts == sorted(counts)
    assert counts[-1] == 50


def test_less_than_a_second_is_lost_when_a_run_is_killed(tmp_path: Path) -> None:
    writer = RunLog(tmp_path, MOUNT)
    for k in range(50):
        writer.on_step(step(k))
        assert k + 1 - len(list(logged_observations(tmp_path / "log.mcap"))) < 10
    writer.close()


def test_a_stamp_beyond_the_range_of_ros_is_clipped(tmp_path: Path) -> None:
    writer = RunLog(tmp_path, MOUNT)
    for stamp in (-5.0, 1e18):
        seen = observation(0)
        scan = LaserScan(stamp, -2.0, 0.0125, 0.0625, 4.0, seen.scan.ranges)
        writer.on_step(Step(0, Observation(scan, seen.odometry), Estimate(stamp, Pose2D()), Twist2D(), 0.0))
    writer.close()
    assert [seen.scan.stamp for seen in logged_observations(tmp_path / "log.mcap")] == [0.0, 2.0**31 - 1]


def test_the_covariance_is_in_the_steps(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("name: cut off\n")
    recorder = Recorder(tmp_path, Pose2D(), MOUNT)
    recorder.on_step(step(0))
    record = RunRecord.open(tmp_path)
    names = ("cov_xx", "cov_xy", "cov_xth", "cov_yy", "cov_yth", "cov_thth")
    assert [record.traces.steps[name][0] for name in names] == list(COVARIANCE[np.triu_indices(3)])
    assert record.metrics is None
    assert record.metrics is None
    recorder.close()


def test_a_run_folder_is_read_back(small_log: Path, tmp_path: Path) -> None:
    experiment: Experiment = replay_experiment(small_log, load_scenario("replay"))
    outcome = experiment.run(tmp_path / "run", pictures=False)
    record = RunRecord.open(outcome.folder)
    assert record.metrics is not None
    assert record.metrics == outcome.metrics
    assert record.config.slam == experiment.scenario.slam
    assert len(list(record.observations())) == len(record.traces.stamps) == 12
    assert len(record.segments[0]) == len(record.segments[1]) == outcome.metrics["segments"]
    np.testing.assert_allclose(record.walls, experiment.slam.lines.ends)
    assert record.outlines == []
    (outcome.folder / "map.json").unlink()
    assert len(RunRecord.open(outcome.folder).walls) == outcome.metrics["segments"]


@pytest.mark.parametrize(
    ("files", "complaint"), [({}, "no config.yaml"), ({"config.yaml": "name: a\n"}, "this run has no scan")]
)
def test_a_folder_that_is_not_a_run_is_refused(tmp_path: Path, files: dict[str, str], complaint: str) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=complaint):
        RunRecord.open(tmp_path)
    with pytest.raises(InputError, match="no such folder; give the folder of a run"):
        RunRecord.open(tmp_path / "nowhere")
