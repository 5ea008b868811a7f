"""``hopslam bench loops``: scores of loops against a reference, tables, and small runs."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from slam.bench.block_log import block_log
from slam.bench.loops.block_table import block_table
from slam.bench.loops.both_ways import BothWays, run_both_ways
from slam.bench.loops.log_results import LogResult, TrajectoryScore
from slam.bench.loops.log_tables import cost_table, error_table, noise_table, place_table
from slam.bench.loops.loop_errors import LoopCounts, count_loops, is_wrong, loop_errors
from slam.bench.loops.place_hits import PlaceHits, place_hits, rank_of
from slam.bench.loops.sim_drives import drive
from slam.bench.loops.sim_tables import hour_table
from slam.bench.loops_report import LoopBench, loop_tables
from slam.bench.map_shape import LoopGap, rms_off_axes
from slam.cli.main import app
from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.graph.closure import ClosedRun
from slam.graph.graph_size import GraphSize
from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.submap import Submap
from slam.line_slam import LineSlam
from slam.pose import FloatArray, compose_poses, inverse_poses, stack_poses
from slam.run.scoring.pose_errors import InterpolatedPoses, PoseErrors

NAN = float("nan")
SMALL = block_log(1, 90)
"""90 scans from a walk between blocks of rooms."""
DRIFT = np.array([3.0, -2.0, 0.4])


@pytest.fixture(scope="module")
def both() -> BothWays:
    return run_both_ways(SMALL, SlamConfig())


def run_with_loops(
    like: ClosedRun, errors: FloatArray, T_base_laser: FloatArray
) -> tuple[ClosedRun, InterpolatedPoses]:
    """Make a run along x and back, and its true poses. On the way back the front end is off by DRIFT. Each loop
    corrects that, except for its row of ``errors`` (L, 3)."""
    there = np.column_stack([np.arange(0.0, 8.0), np.zeros((8, 2))])
    back = np.column_stack([np.arange(7.2, -0.8, -1.0), np.full(8, 0.1), np.full(8, np.pi)])
    truth = np.concatenate([there, back])
    local = compose_poses(np.concatenate([there, compose_poses(DRIFT, back)]), T_base_laser)
    empty, lidar = np.empty((0, 7)), SMALL.lidar
    keys = [KeyScan(pose, (k // 8,), empty, np.empty(0, np.float32), lidar, index=k) for k, pose in enumerate(local)]
    submaps = [Submap(n, n, local[8 * n], False, list(range(8 * n, 8 * n + 8))) for n in (0, 1)]
    loops = [
        Loop(k, 1, 0, compose_poses(error, inverse_poses(DRIFT)), "odometry", 1, 1, 1.0, False, (), 15)
        for k, error in enumerate(errors)
    ]
    weights = np.array([1.0, 0.2] * len(loops))[: len(loops)]
    closed = replace(
        like,
        keys=tuple(keys),
        submaps=tuple(submaps),
        loops=tuple(loops),
        weights=weights,
        T_base_laser=T_base_laser,
        size=GraphSize(tried=9),
    )
    return closed, InterpolatedPoses(truth, np.ones(16, np.bool_))


@pytest.mark.parametrize("mount", [np.zeros(3), np.array([0.2, -0.1, 0.5])])
def test_the_error_of_a_loop_is_its_known_offset(mount: FloatArray, both: BothWays) -> None:
    closed, truth = run_with_loops(both.closed, np.array([[0.0, 0.0, 0.0], [0.3, 0.4, 0.0], [0.0, 0.0, 0.05]]), mount)
    found = loop_errors(closed, truth)
    np.testing.assert_allclose(found.metres[:2], [0.0, 0.5], atol=1e-9)
    np.testing.assert_allclose(found.radians, [0.0, 0.0, 0.05], atol=1e-9)


@given(st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-3, 3)))
@settings(max_examples=20)
def test_the_frame_of_the_reference_does_not_matter(both: BothWays, moved: tuple[float, float, float]) -> None:
    closed, truth = run_with_loops(both.closed, np.array([[0.1, 0.2, 0.03]]), np.array([0.1, 0.0, 0.2]))
    elsewhere = truth._replace(poses=compose_poses(np.array(moved), truth.poses))
    np.testing.assert_allclose(loop_errors(closed, truth), loop_errors(closed, elsewhere), atol=1e-9)


def test_distant_loops_are_wrong_or_have_no_reference(both: BothWays) -> None:
    assert is_wrong(PoseErrors(np.array([0.49, 0.51, 0.0, NAN]), np.array([0.1, 0.0, 0.11, NAN]))).tolist() == [
        False, True, True, False,
    ]  # fmt: skip
    closed, truth = run_with_loops(
        both.closed, np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), np.zeros(3)
    )
    assert count_loops(closed, truth) == LoopCounts(
        tried=9, accepted=3, judged=3, wrong=1, believed=2, believed_wrong=1
    )
    unknown = truth._replace(known=np.zeros(16, np.bool_))
    assert count_loops(closed, unknown) == LoopCounts(
        tried=9, accepted=3, judged=0, wrong=0, believed=2, believed_wrong=0
    )


def result(**changed: Any) -> LogResult:
    score = TrajectoryScore(NAN, NAN, 0.5, None, 40.0)
    times = np.array([0.001, 0.001, 0.002])
    return LogResult(
        "aces", 3, score, score._replace(ate=0.3), score._replace(ate=0.1), NAN, NAN, None, None, times, 2.0 * times,
        0.010, 0.002,
    )._replace(**changed)  # fmt: skip


def test_the_cost_ratio_counts_all_threads_and_the_end() -> None:
    (row,) = cost_table([result()]).rows
    assert row == ("aces", "3", "1.000", "1.98", "2.000", "3.96", "0.00", "3.00")


def test_the_noisy_runs_show_their_median_and_their_worst() -> None:
    score = result().final
    runs = [result(final=score._replace(ate=ate)) for ate in (0.1, 0.9, 0.2)]
    median, worst = noise_table(runs).rows
    assert median == ("aces, median of 3", "0.5000", "0.3000", "0.2000")
    assert worst[-1] == "0.9000"


def test_each_measure_has_a_row_beside_the_published() -> None:
    open_loop = result().final._replace(ate=NAN, gap=LoopGap(0.3, 0.4, np.radians(-2.0), 0.9, 0.5))
    (ate, crisp, *duke) = error_table([result(), result(name="duke", final=open_loop, unclosed_off_axes=0.1)]).rows
    assert ate == ("aces", "ATE", "0.5000", "0.3000", "0.1000", "0.0", "0.1730", "0.0600", "0.0440", "0.0375")
    assert crisp[:2] == ("", "crisp")
    assert [row[1] for row in duke] == ["open, m", "open, deg", "off axes, deg", "crisp"]
    assert [row[4] for row in duke[:2]] == ["0.50", "2.00"]
    assert duke[2][2] == "5.73"


def test_the_rank_is_that_of_the_first_correct_place() -> None:
    places = np.array([[1.0, 0.0, 0.0], [0.0, 0.5, 0.2], [0.0, 0.5, 0.1], [0.0, 0.0, 2.0 * np.pi]])
    assert rank_of(np.zeros(3), places) == 2
    assert rank_of(np.zeros(3), places[3:]) == 0
    assert rank_of(np.zeros(3), places[:2]) == 6


def test_shares_of_places_count_existing_pairs() -> None:
    (row,) = place_table(
        [result(places=PlaceHits(4, (1, 2, 4), 0.008)), result(places=PlaceHits(0, (0, 0, 0), 0.0))]
    ).rows
    assert row == ("aces", "4", "0.25", "0.50", "1.00", "2.00")


def test_a_run_without_a_return_has_no_pairs(both: BothWays) -> None:
    assert SMALL.T_map_base is not None
    truth = InterpolatedPoses(SMALL.T_map_base, np.ones(len(SMALL), np.bool_))
    assert place_hits(both.closed, truth) == PlaceHits(0, (0, 0, 0), pytest.approx(0.0, abs=1e-3))
    one_spot = InterpolatedPoses(np.zeros((len(SMALL), 3)), truth.known)
    assert place_hits(both.closed, one_spot).pairs > 0


def test_short_walls_do_not_define_the_axes() -> None:
    """One of three long walls is turned by 3 deg, which turns the mean by 1 deg; they are 1, 1 and 2 deg off it."""
    c, s = np.cos(np.radians(3.0)), np.sin(np.radians(3.0))
    walls = np.array([[[0, 0], [4, 0]], [[0, 0], [0, 4]], [[0, 5], [4 * c, 5 + 4 * s]], [[0, 0], [0.5, 0.9]]])
    assert np.degrees(rms_off_axes(walls)) == pytest.approx(np.sqrt((1.0 + 1.0 + 4.0) / 3.0), abs=0.01)
    assert np.isnan(rms_off_axes(walls[3:]))


def test_both_modes_get_the_same_scans_and_one_closes_loops(both: BothWays) -> None:
    alone = LineSlam(SlamConfig(loops="never"), SMALL.T_base_laser)
    poses = stack_poses(alone.update(SMALL.scan(k), SMALL.odometry(k)).T_map_base for k in range(len(SMALL)))
    assert np.array_equal(both.unclosed, poses)
    assert both.live.shape == both.final.shape == both.unclosed.shape
    assert len(both.unclosed_times) == len(both.live_times) == len(SMALL)
    assert both.live_total > 0.9 * both.live_times.sum()


def test_a_run_in_both_modes_is_repeated_bit_for_bit(both: BothWays) -> None:
    again = run_both_ways(SMALL, SlamConfig())
    assert np.array_equal(both.live, again.live)
    assert np.array_equal(both.final, again.final)
    assert both.closed.size.tried == again.closed.size.tried


def test_a_building_has_rows_with_and_without_loops() -> None:
    table = block_table(0, SlamConfig(), Terminal(quiet=True), scans=40)
    assert [row[:2] for row in table.rows] == [("never", "40"), ("auto", "40")]
    assert {len(row) for row in table.rows} == {len(table.columns)}


def test_an_hour_has_a_row_every_five_minutes() -> None:
    table = hour_table(drive("office_loop", 0, ("duration=8", "slam.loops=auto")))
    assert [row[0] for row in table.rows] == [str(minutes) for minutes in range(5, 65, 5)]
    keys = [int(row[5]) for row in table.rows]
    assert keys == sorted(keys)
    assert keys[-1] > 4


def test_the_command_runs_both_modes(tmp_path: Path) -> None:
    out = tmp_path / "loops.md"
    arguments = ["bench", "loops", "sim", "--seeds", "1", "--set", "duration=2", "--out", str(out)]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    text = out.read_text()
    assert "| office_loop, 10 | duration over |" in text
    assert "| campus_loop | 1 | 0 | never |" in text
    assert "| 0, 0 |" in text


def test_missing_logs_are_skipped_and_unknown_parts_named(tmp_path: Path) -> None:
    shown = CliRunner().invoke(app, ["bench", "loops", "logs", "--stress", "--log", "fr079", "--data", str(tmp_path)])
    assert shown.exit_code == 0
    assert shown.output.count("; skipped") == 2
    shown = CliRunner().invoke(app, ["bench", "loops", "logs", "--variant", "every=5"])
    assert isinstance(shown.exception, InputError)
    with pytest.raises(InputError, match="no part 'log'; did you mean logs"):
        list(loop_tables(["log"], LoopBench(tmp_path)))
