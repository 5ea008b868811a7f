"""The measures of ``hopslam bench slam``, by hand and compared with evo."""

import gzip
import json
import shlex
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from evo.core import metrics
from evo.core.trajectory import PosePath3D
from typer.testing import CliRunner

from slam.bench.log_runs import odometry_with_doubled_noise, run_log
from slam.bench.map_shape import angles_off_main_axes, crispness, loop_gap
from slam.bench.sim_report import hour_tables, sim_tables, unconstrained_tables
from slam.bench.sim_runs import repeating_command, run_scenario
from slam.bench.slam_report import slam_tables
from slam.bench.wall_faults import wall_faults
from slam.cli.main import app
from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.files.tum import format_tum
from slam.pose import FloatArray, Pose2D
from slam.run.scoring.pose_errors import absolute_error, poses_at, read_relations, relation_errors, relative_error

NO_ECHOES = np.empty((0, 2)), np.empty((0, 2))


def wander(seed: int, count: int = 60) -> FloatArray:
    random = np.random.default_rng(seed)
    return np.cumsum(random.normal([[0.5, 0.1, 0.02]], 0.05, (count, 3)), axis=0)


def as_evo(poses: FloatArray) -> PosePath3D:
    half = poses[:, 2] / 2.0
    zero = np.zeros(len(poses))
    return PosePath3D(np.column_stack([poses[:, :2], zero]), np.column_stack([np.cos(half), zero, zero, np.sin(half)]))


def test_the_absolute_error_is_evo_s() -> None:
    truth, estimate = wander(0), wander(0) + np.random.default_rng(1).normal(0.0, 0.1, (60, 3))
    reference, moved = as_evo(truth), as_evo(estimate)
    moved.align(reference)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((reference, moved))
    assert absolute_error(estimate, truth) == pytest.approx(ape.get_statistic(metrics.StatisticsType.rmse), abs=1e-6)


def test_errors_are_those_calculated_by_hand() -> None:
    straight = np.column_stack([np.arange(31.0), np.zeros(31), np.zeros(31)])
    assert absolute_error(straight, straight) == pytest.approx(0.0, abs=1e-9)
    assert relative_error(straight * [1.02, 1.0, 1.0], straight) == pytest.approx(0.2)
    at = poses_at(np.array([0.25, 40.0]), np.arange(31.0), straight)
    np.testing.assert_allclose(at.poses[0], [0.25, 0.0, 0.0])
    assert at.known.tolist() == [True, False]


def test_relations_are_those_calculated_by_hand(tmp_path: Path) -> None:
    """The trajectory moves 3 m from 1 s to 4 s; the relation says 2.9 m and 0.1 rad."""
    path = tmp_path / "a.relations.gz"
    with gzip.open(path, "wt") as file:
        file.write("1 4 2.9 0 0 0 0 0.1\n2 5 3 0 0 0 0 0\n")
    found = relation_errors(
        read_relations(path), np.arange(9.0), np.column_stack([np.arange(9.0), np.zeros(9), np.zeros(9)])
    )
    np.testing.assert_allclose(found.metres, [0.1, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.radians, [0.1, 0.0], atol=1e-12)


def test_a_small_log_is_benchmarked(small_log: Path) -> None:
    run = run_log(small_log, SlamConfig())
    np.testing.assert_allclose(run.poses[-1], [0.55, 0.0, 0.0], atol=0.01)
    true, smeared = (
        crispness(run.log, poses, 0, 15.0, False) for poses in (run.poses, run.poses + np.arange(12)[:, None])
    )
    assert 2.0 * true < smeared
    assert run.lost == 0


def test_wheel_noise_is_repeatable() -> None:
    truth = np.column_stack([np.linspace(0, 20, 200), np.zeros(200), np.zeros(200)])
    once = odometry_with_doubled_noise(truth, 0)
    np.testing.assert_array_equal(once, odometry_with_doubled_noise(truth, 0))
    assert np.hypot(*np.diff(once[:, :2], axis=0).T).sum() == pytest.approx(20.8)


def test_missing_logs_are_skipped_and_named(tmp_path: Path) -> None:
    printed = StringIO()
    console = Terminal(file=printed)
    assert slam_tables(["fr079"], tmp_path, SlamConfig(), console) == []
    assert "fr079.log.gz; skipped" in printed.getvalue()


def test_a_run_in_the_simulator_is_measured_against_the_truth() -> None:
    run = run_scenario("cluttered_room", 0, ("duration=2",))
    count = len(run.poses)
    assert run.covariances.shape == (count, 3, 3)
    assert run.normalised_errors.shape == (count - 1,)
    assert len(run.times) == count
    assert np.abs(run.offsets).max() < 0.05
    np.testing.assert_allclose(run.odometry_offsets[0], 0.0, atol=1e-9)


def test_the_tables_of_the_simulator_are_written() -> None:
    each, together, again = sim_tables(["cluttered_room"], range(3, 4), False, ("duration=1",), Terminal(quiet=True))
    assert each.rows[0][0] == "cluttered_room, 3"
    assert together.rows[0][:2] == ("cluttered_room", "1")
    assert again.rows[0][2] == "hopslam run cluttered_room --seed 3 --set lidar.caster=exact --set duration=1"
    assert {len(row) for row in each.rows} == {len(each.columns)}


def test_the_command_of_a_run_repeats_it(tmp_path: Path) -> None:
    """The poses agree to the last digit in the run's folder."""
    arguments = "crowded_corridor", 4, ("duration=3", "slam.map.free_margin=0.1")
    run, words = run_scenario(*arguments), shlex.split(repeating_command(*arguments))
    assert CliRunner().invoke(app, [*words[1:], "--out", str(tmp_path / "run")]).exit_code == 0
    for name, poses in (("trajectory", run.poses), ("groundtruth", run.truth)):
        lines = (tmp_path / "run" / f"{name}.tum").read_text().splitlines()
        stamps = [float(line.split()[0]) for line in lines]
        again = [format_tum(stamp, Pose2D.from_array(pose)) for stamp, pose in zip(stamps, poses, strict=True)]
        assert lines == again
    saved = json.loads((tmp_path / "run" / "map.json").read_text())
    assert saved["robot"]["T_map_base"] == pytest.approx(run.poses[-1], abs=0.01)  # refined after the last scan


def test_the_angle_of_walls_to_the_axes_is_measured() -> None:
    """Two walls at a right angle, and one turned by 0.02 rad, which turns the axes by a third of that."""
    walls = np.array([[[0, 0], [4, 0]], [[0, 0], [0, 4]], [[0, 5], [4 * np.cos(0.02), 5 + 4 * np.sin(0.02)]]])
    angles, lengths = angles_off_main_axes(walls)
    np.testing.assert_allclose(angles, [-0.02 / 3, -0.02 / 3, 0.04 / 3], atol=1e-5)
    np.testing.assert_allclose(lengths, 4.0)


def test_the_gap_of_a_loop_is_its_known_offset() -> None:
    """An L of points, laid down again 0.3 m back, 0.2 m to the right and turned by 2 deg."""
    first = np.concatenate([np.column_stack([np.arange(0, 4, 0.03), np.zeros(134)]), np.array([[4.0, 0.0]])])
    first = np.concatenate([first, first[:, ::-1]]) + np.array([2.0, 1.0])
    turn, middle = np.radians(2.0), first.mean(axis=0)
    c, s = np.cos(turn), np.sin(turn)
    last = (first - middle) @ np.array([[c, s], [-s, c]]) + middle - [0.3, 0.2]
    gap = loop_gap(first, last, 0.0)
    np.testing.assert_allclose([gap.along, gap.across, gap.turn], [0.3, 0.2, -turn], atol=0.06)
    assert gap.agreement > 0.95 > 0.7 > gap.before


def test_an_open_direction_is_scored_by_odometry() -> None:
    """Along the corridor the error equals that of dead reckoning with the true heading, for which SLAM is not to
    blame."""
    run = run_scenario("featureless_corridor", 1, ("duration=12",))
    assert run.unconstrained[1:].mean() >= 0.95
    np.testing.assert_allclose(run.offsets[:, 0], run.true_heading_offsets[:, 0], atol=0.002)
    (table,) = unconstrained_tables([("featureless_corridor", 1, run)])
    assert [row[0] for row in table.rows] == ["featureless_corridor, 1", "median", "worst"]
    assert unconstrained_tables([("cluttered_room", 0, run_scenario("cluttered_room", 0, ("duration=1",)))]) == []


def test_the_tables_of_an_hour_are_written() -> None:
    cost, sizes = hour_tables(run_scenario("office_loop", 0, ("duration=3",)))
    assert cost.rows[0][0] == "30"
    assert [row[0] for row in sizes.rows][-1] == "60 min"
    assert len(sizes.rows) == 12


def fan_of_echoes(lines: FloatArray, origin: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Echoes every 2 cm of the lines, and the origin of their beams."""
    shares = np.linspace(0.0, 1.0, 51)[:, None]
    points = np.concatenate([(1.0 - shares) * start + shares * end for start, end in lines])
    return points, np.tile(np.array(origin), (len(points), 1))


WALL, ALONG_A_BEAM = np.array([[[1.0, -0.5], [1.0, 0.5]]]), np.array([[[2.0, 0.02], [3.0, 0.0]]])


def test_a_line_along_its_own_beams_is_radial() -> None:
    lines = np.concatenate([WALL, ALONG_A_BEAM, 0.1 * ALONG_A_BEAM])
    found = wall_faults(lines, *fan_of_echoes(lines, (0.0, 0.0)))
    assert found.radial == pytest.approx(1.0, abs=1e-3)  # the short one has no sure direction
    assert wall_faults(lines, *fan_of_echoes(lines, (2.5, 3.0))).radial == 0.0
    assert wall_faults(lines, *NO_ECHOES).unseen == pytest.approx(2.1, abs=1e-3)


def test_lines_beside_a_longer_one_are_parallel() -> None:
    beside = WALL * [1.0, 0.5] + np.array([0.2, 0.4])  # half as long, reaches 0.15 m beyond its end
    assert wall_faults(np.concatenate([WALL, beside]), *NO_ECHOES).parallel == pytest.approx(0.35, abs=0.05)
    assert (
        wall_faults(np.concatenate([WALL, beside[:, ::-1]]), *NO_ECHOES).parallel == 0.0
    )  # the other face of a thin wall
    assert wall_faults(np.concatenate([WALL, WALL + np.array([0.35, 0.0])]), *NO_ECHOES).parallel == 0.0
    assert (
        wall_faults(np.concatenate([WALL, WALL + np.array([0.0, 1.0])]), *NO_ECHOES).parallel == 0.0
    )  # one wall in two pieces
    assert wall_faults(np.concatenate([WALL] * 3), *NO_ECHOES).parallel == pytest.approx(2.0)


def test_an_empty_map_has_no_faults() -> None:
    assert wall_faults(np.empty((0, 2, 2)), np.zeros((1, 2)), np.zeros((1, 2)))[:4] == (0.0, 0.0, 0.0, 0.0)
