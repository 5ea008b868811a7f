"""``hopslam bench walls``: other line maps of the same poses, and the tables."""

from pathlib import Path

import numpy as np
import pytest

from slam.bench.merged_lines import MergedLines
from slam.bench.wall_map_runs import LINE_MAPS, OURS, run_wall_map, total_score
from slam.bench.walls_report import wall_tables
from slam.console.terminal import Terminal
from slam.lines.segments import Segments
from slam.pose import FloatArray, Pose2D
from slam.run.experiment_setup import scenario_experiment
from slam.run.run_and_report import summary_tables
from slam.run.scoring.wall_score import wall_metrics
from slam.scenario.file import load_scenario

ROOM = """
world:
  walls:
    - {points: [[0, 0], [3, 0], [3, 2], [0, 2]], closed: true}
robot: {start: {x: 0.8, y: 1.0}}
route: {waypoints: [[2.0, 1.0]]}
"""


ORIGIN = Pose2D()


def segments(*lines: list[float]) -> Segments:
    """Segments of 10 points from x, y to x, y."""
    ends = np.array(lines).reshape(-1, 2, 2)
    way = ends[:, 1] - ends[:, 0]
    theta = np.arctan2(-way[:, 0], way[:, 1])
    rho = ends[:, 0, 0] * np.cos(theta) + ends[:, 0, 1] * np.sin(theta)
    first = np.zeros(len(ends), np.int64)
    return Segments(first, first + 9, rho, theta, ends[:, 0], ends[:, 1])


def merged(*scans: Segments, T_map_laser: Pose2D = ORIGIN) -> FloatArray:
    lines = MergedLines()
    for scan in scans:
        lines.add(scan, T_map_laser)
    return lines.ends


def test_segments_of_one_wall_are_merged_into_its_whole_length() -> None:
    ends = merged(segments([0, 0, 1, 0]), segments([0.5, 0.02, 2, 0.02]), segments([2.1, 0.01, 3, 0.01]))
    assert ends.shape == (1, 2, 2)
    assert ends[0, :, 0] == pytest.approx([0.0, 3.0], abs=0.01)
    assert ends[0, :, 1] == pytest.approx(0.01, abs=0.01)


def test_a_segment_across_a_gap_joins_two_lines() -> None:
    assert len(merged(segments([0, 0, 1, 0], [1.3, 0, 2, 0]))) == 2
    assert len(merged(segments([0, 0, 1, 0], [1.3, 0, 2, 0]), segments([0.9, 0, 1.4, 0]))) == 1


@pytest.mark.parametrize("other", [[1, 0, 0, 0], [0, 0.2, 1, 0.2], [1.3, 0, 2, 0], [0.5, 0, 0.5, 1]])
def test_other_faces_walls_and_gaps_stay_apart(other: list[float]) -> None:
    assert len(merged(segments([0, 0, 1, 0]), segments(other))) == 2


def test_a_map_is_in_the_frame_of_the_map() -> None:
    T = Pose2D(1.0, 2.0, np.pi / 2)
    assert merged(segments([1, 0, 2, 0]), T_map_laser=T)[0] == pytest.approx(np.array([[1.0, 3.0], [1.0, 4.0]]))


def test_rows_have_all_scores_and_the_command(tmp_path: Path) -> None:
    path = tmp_path / "my room.yaml"
    path.write_text(ROOM)
    run = run_wall_map(str(path), 3, ["lidar.noise=none"])
    assert set(run.scores) == set(LINE_MAPS)
    scenario = load_scenario(path, ["lidar.noise=none", "seed=3"])
    metrics = scenario_experiment(scenario).run(tmp_path / "run", pictures=False).metrics
    assert metrics == metrics | wall_metrics(run.scores[OURS])
    assert (metrics["ending"], run.ending) == ("arrived", "arrived")
    assert metrics["wall_seen_m"] > 5.0
    shown = {row[0]: row[1] for table in summary_tables(metrics) for row in table.rows}
    assert shown["line map"].startswith(f"{100 * metrics['wall_precision']:.1f} % of ")
    twice = total_score([run.scores[OURS]] * 2)
    assert twice.precision == run.scores[OURS].precision
    assert len(twice.end_errors) == 2 * len(run.scores[OURS].end_errors)
    ways, worst = wall_tables([str(path)], [3], ("lidar.noise=none",), Terminal(quiet=True))
    assert [row[1] for row in ways.rows] == list(LINE_MAPS)
    assert worst.rows[0][-1] == f"hopslam run '{path}' --seed 3 --set lidar.caster=exact --set lidar.noise=none"
