"""Whole runs, set up and measured."""

import json
from itertools import count
from math import cos, sin
from pathlib import Path

import numpy as np
import pytest

from slam.files.tum import read_tum
from slam.pose import FloatArray, Pose2D
from slam.run import experiment
from slam.run.experiment import Experiment
from slam.run.experiment_setup import replay_experiment, scenario_experiment
from slam.scenario.file import load_scenario

MOUNT = 0.3
TURN = 0.06
"""Radians from one scan to the next."""


def walls_seen_from(x: float, y: float, bearings: FloatArray) -> FloatArray:
    """Ranges in a room from (-3, -1.5) to (4, 2), metres."""
    directions, place = np.column_stack([np.cos(bearings), np.sin(bearings)]), np.array([x, y])
    with np.errstate(divide="ignore"):
        ranges = np.maximum(([4.0, 2.0] - place) / directions, ([-3.0, -1.5] - place) / directions).min(axis=1)
    return np.asarray(ranges)


@pytest.fixture
def turning_log(tmp_path: Path) -> Path:
    """A robot that turns on the spot by 55 degrees, its laser 0.3 m ahead of its centre."""
    bearings = np.linspace(-np.pi / 2, np.pi / 2, 181)
    lines = []
    for k in range(17):
        theta = TURN * k
        x, y = MOUNT * cos(theta), MOUNT * sin(theta)
        readings = " ".join(f"{reading:.3f}" for reading in walls_seen_from(x, y, theta + bearings))
        lines.append(
            f"ROBOTLASER1 0 -1.570796 3.141593 0.017453 80 0.01 0 181 {readings} 0 "
            f"{x:.6f} {y:.6f} {theta:.6f} 0 0 {theta:.6f} 0 0 0 0 0 {0.1 * k:.3f} host {0.1 * k:.3f}"
        )
    path = tmp_path / "turning.log"
    path.write_text("\n".join(lines) + "\n")
    return path


def replayed(log: Path, *settings: str, scenario: str = "replay") -> Experiment:
    return replay_experiment(log, load_scenario(scenario, settings))


def test_turning_on_the_spot_keeps_the_base_in_place(turning_log: Path, tmp_path: Path) -> None:
    """If the laser were assumed to be at the robot's centre, the base would seem to move by 28 cm."""
    run = replayed(turning_log, "slam.update_distance=0")
    assert run.slam.T_base_laser.distance(Pose2D(MOUNT)) < 1e-3
    folder = run.run(tmp_path / "run", pictures=False).folder
    _, poses = read_tum(folder / "trajectory.tum")
    assert len(poses) == 17
    assert np.hypot(poses[:, 0], poses[:, 1]).max() < 0.05
    np.testing.assert_allclose(poses[:, 2], TURN * np.arange(17), atol=0.02)


def test_the_kept_lines_are_those_of_the_map(turning_log: Path, tmp_path: Path) -> None:
    run = replayed(turning_log, scenario="paper_replay")
    features = json.loads((run.run(tmp_path / "run", pictures=False).folder / "lines.geojson").read_text())["features"]
    ends = [feature["geometry"]["coordinates"] for feature in features]
    np.testing.assert_allclose(ends, run.slam.lines.ends, atol=1e-4)


def test_the_real_time_factor_is_recorded_time_over_wall_time(
    small_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The log lasts 1.1 s. The clock advances by 0.5 s per call, and is read at the start and at the end."""
    monkeypatch.setattr(experiment, "perf_counter", count(0.0, 0.5).__next__)
    metrics = replayed(small_log, "slam.loops=never").run(tmp_path / "run", pictures=False).metrics
    assert metrics["duration_s"] == pytest.approx(1.1)
    assert metrics["real_time_factor"] == pytest.approx(1.1 / 0.5, abs=0.01)


@pytest.mark.parametrize("scenario", ["replay", "paper_replay"])
def test_the_map_points_are_those_of_the_map(small_log: Path, tmp_path: Path, scenario: str) -> None:
    run = replayed(small_log, "slam.update_distance=0.1", scenario=scenario)
    outcome = run.run(tmp_path / "run", pictures=False)
    steps = np.genfromtxt(outcome.folder / "steps.csv", delimiter=",", names=True)
    assert steps["map_points"][0] == 181 or scenario == "replay"
    assert outcome.metrics["map_points"] == steps["map_points"][-1] == len(run.slam.points) > 30
    assert not (np.diff(steps["map_points"]) > 0)[steps["mapped"][1:] == 0].any()


def test_dead_reckoning_starts_at_the_given_pose(tmp_path: Path) -> None:
    """It must not start at the origin, as it is drawn over the map and compared with the truth."""
    scenario = load_scenario("paper_simulation", ["duration=1"])
    folder = scenario_experiment(scenario).run(tmp_path / "run", pictures=False).folder
    (_, odometry), (_, truth) = (read_tum(folder / name) for name in ("odometry.tum", "groundtruth.tum"))
    np.testing.assert_allclose(odometry[0], [1.0, 1.0, np.pi / 2], atol=1e-3)
    assert len(odometry) == len(truth) > 5
    assert np.hypot(*(odometry - truth)[:, :2].T).max() < 0.05
    assert truth[-1, 1] - truth[0, 1] > 0.05
