"""The run folder: readable at every moment, with standard metrics."""

import json
import signal
import subprocess
import sys
import textwrap
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.files.atomic_files import GrowingGeoJson, atomic_file, write_atomic
from slam.files.tum import format_tum
from slam.line_slam import Estimate
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation
from slam.run.pictures.map_picture import draw_map
from slam.run.results.metrics import measure
from slam.run.results.recorder import STEP_COLUMNS
from slam.run.results.run_folder import make_run_folder
from slam.run.step import Step
from slam.run.watchers import RunProgress
from slam.scan import LaserScan


def test_an_atomic_file_leaves_no_draft(tmp_path: Path) -> None:
    path = tmp_path / "metrics.json"
    for text in ("old", "new"):
        write_atomic(path, text)
        assert path.read_text() == text
    assert list(tmp_path.iterdir()) == [path]


def test_a_growing_geojson_is_valid_after_every_append(tmp_path: Path) -> None:
    path = tmp_path / "lines.geojson"
    with GrowingGeoJson(path, frame="map") as file:
        assert json.loads(path.read_text())["features"] == []
        for count in range(1, 4):
            file.append([{"type": "Feature", "id": count}])
            content = json.loads(path.read_text())
            assert [feature["id"] for feature in content["features"]] == list(range(1, count + 1))
        file.append([])
    assert json.loads(path.read_text()) == content
    assert content["frame"] == "map"


def test_run_folders_are_new_and_latest_points_at_the_last(tmp_path: Path) -> None:
    folders = [make_run_folder("corridor", runs=tmp_path) for _ in range(3)]
    assert len(set(folders)) == 3
    assert (tmp_path / "latest").resolve() == folders[-1].resolve()


def test_a_folder_with_files_is_not_written_to(tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("x")
    with pytest.raises(InputError, match="not empty; choose another --out"):
        make_run_folder("corridor", tmp_path)
    with pytest.raises(InputError, match="cannot make the run folder"):
        make_run_folder("corridor", tmp_path / "precious" / "below")


def random_walk(seed: int, noise: float) -> list[Pose2D]:
    random = np.random.default_rng(seed)
    walk = np.cumsum(np.random.default_rng(0).normal(0, 0.1, (50, 3)), axis=0)
    return [Pose2D(*row) for row in walk + random.normal(0, noise, (50, 3))]


def write_run(folder: Path) -> None:
    for name, seed, noise in (("trajectory", 1, 0.05), ("odometry", 2, 0.2), ("groundtruth", 3, 0.0)):
        lines = [format_tum(0.1 * k, pose) + "\n" for k, pose in enumerate(random_walk(seed, noise))]
        (folder / f"{name}.tum").write_text("".join(lines))
    row = "0.0,1,7,1,100,3,0.1,2.5,0.5,0.0,0,,,,,,,0,0,0,0,-1,0,,0,\n"
    (folder / "steps.csv").write_text(",".join(STEP_COLUMNS) + "\n" + 50 * row)


@pytest.mark.filterwarnings("ignore")  # evo's imports
def test_the_errors_are_those_of_evo(tmp_path: Path) -> None:
    from evo.core.metrics import APE, PoseRelation
    from evo.tools.file_interface import read_tum_trajectory_file

    write_run(tmp_path)
    metrics = measure(tmp_path)
    truth, estimate = (read_tum_trajectory_file(tmp_path / f"{name}.tum") for name in ("groundtruth", "trajectory"))
    for relation, names in (
        (PoseRelation.translation_part, {"rmse": "ate_rmse_m", "max": "ate_max_m"}),
        (PoseRelation.rotation_angle_deg, {"rmse": "heading_rmse_deg", "max": "heading_max_abs_deg"}),
    ):
        ape = APE(relation)
        ape.process_data((truth, estimate))
        for statistic, name in names.items():
            assert metrics[name] == pytest.approx(ape.get_all_statistics()[statistic], abs=1e-5)


def test_metrics_have_all_documented_keys(tmp_path: Path) -> None:
    write_run(tmp_path)
    errors = ("ate_rmse_m", "ate_max_m", "x_max_abs_m", "y_max_abs_m", "heading_max_abs_deg", "heading_rmse_deg")
    work = ("scans", "duration_s", "path_m", "iterations_mean", "iterations_max", "slam_ms_median", "slam_ms_p99")
    more = ("extraction_ms_median", "map_points", "segments")
    assert {*errors, *(f"odometry_{name}" for name in errors), *work, *more} <= measure(tmp_path).keys()


def test_the_work_counts_the_mapped_scans(tmp_path: Path) -> None:
    """The first scan has nothing to be matched to, and the last one is not mapped."""
    write_run(tmp_path)
    mapped = [
        (
            k,
            1,
            10 * k,
            k % 2,
            3 * k,
            2,
            0.1 * k,
            k,
            0.5,
            0.0,
            0,
            *6 * [""],
            int(k in (5, 6, 7)),
            0,
            0,
            0,
            k if k > 46 else -1,
            0,
            "",
            0,
            "",
        )
        for k in range(49)
    ]
    rows = [*mapped, (49, 0, 0, 0, 150, 0, 1000, 1000, 0.5, 0.0, 0, *6 * [""], 1, 0, 0, 0, -1, 0, "", 0, "")]
    text = "".join(",".join(map(str, row)) + "\n" for row in rows)
    (tmp_path / "steps.csv").write_text(",".join(STEP_COLUMNS) + "\n" + text)
    known = {
        "scans": 50,
        "updates": 49,
        "iterations_mean": 245.0,
        "iterations_max": 480,
        "not_converged": 24,
        "closures": 2,
        "odometry_only": 3,
        "odometry_only_share": 0.0612,
        "slam_ms_median": 24.0,
        "slam_ms_p99": 47.52,
        "slam_s_total": 2.176,
        "extraction_ms_median": 2.4,
        "map_points": 150,
        "segments": 98,
    }
    metrics = measure(tmp_path)
    assert {name: metrics[name] for name in known} == pytest.approx(known)


def step_of(truth: Pose2D | None, estimate: Pose2D) -> Step:
    scan = LaserScan(0.0, -0.5, 0.5, 0.1, 9.0, np.ones(3))
    return Step(0, Observation(scan, Odometry(0.0, Pose2D()), truth), Estimate(0.0, estimate), Twist2D(), 0.5)


def shown_by_the_bar(step: Step) -> str:
    text = StringIO()
    with RunProgress(Terminal(file=text, force_terminal=True, width=200), "corridor") as bar:
        bar.on_step(step)
    return text.getvalue()


def test_the_bar_shows_the_error_where_the_truth_is_known() -> None:
    estimate = Pose2D(1.0, 2.032, 0.5)
    shown = shown_by_the_bar(step_of(Pose2D(1.0, 2.0, 0.5), estimate))
    assert all(part in shown for part in ("corridor", "50%", "1 scans", "error 3.2 cm"))
    assert "error" not in shown_by_the_bar(step_of(None, estimate))


def grey_pixels(folder: Path, outlines: list[FloatArray]) -> int:
    """Count the pixels of ``map.png`` in the colour that walls are filled with."""
    draw_map(folder, np.array([[-2.0, -2.0], [2.0, 2.0]]), np.empty((0, 2, 2)), outlines)
    picture = imread(folder / "map.png")
    return int((np.abs(picture[:, :, :3] - 0.88) < 0.01).all(axis=2).sum())


def test_the_true_walls_are_drawn(tmp_path: Path) -> None:
    write_run(tmp_path)
    wall = np.array([[-1.5, -1.5], [-0.5, -1.5], [-0.5, 1.5], [-1.5, 1.5]])
    bare = grey_pixels(tmp_path, [])
    one = grey_pixels(tmp_path, [wall]) - bare
    two = grey_pixels(tmp_path, [wall, wall + np.array([2.0, 0.0])]) - bare
    assert one > 10_000
    assert two == pytest.approx(2 * one, rel=0.1)


KILLED = """
    import os, sys
    from slam.run import experiment
    from slam.run.experiment_setup import scenario_experiment
    from slam.scenario.file import load_scenario
    from pathlib import Path

    class KillAtStep20:
        def __init__(self, *_): pass
        def __enter__(self): return self
        def __exit__(self, *_): pass
        def on_step(self, step):
            if step.index == 20:
                os.kill(os.getpid(), {signal})

    experiment.RunProgress = KillAtStep20
    outcome = scenario_experiment(load_scenario("paper_simulation")).run(Path(sys.argv[1]))
    print(outcome.ending)
"""


def hear_ctrl_c() -> None:
    """Enable SIGINT in a child whose parent ignores it, as a shell does for background jobs."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.mark.parametrize("name", ["SIGKILL", "SIGINT"])
def test_results_survive_a_failure(name: str, tmp_path: Path) -> None:
    number = getattr(signal, name)
    code = textwrap.dedent(KILLED).format(signal=int(number))
    ended = subprocess.run(
        [sys.executable, "-c", code, tmp_path / "run"], capture_output=True, text=True, preexec_fn=hear_ctrl_c
    )
    assert len((tmp_path / "run" / "trajectory.tum").read_text().splitlines()) == 21
    assert len((tmp_path / "run" / "steps.csv").read_text().splitlines()) == 22
    assert len(json.loads((tmp_path / "run" / "lines.geojson").read_text())["features"]) > 50
    assert (tmp_path / "run" / "config.yaml").is_file()
    if name == "SIGINT":
        assert ended.stdout.strip() == "interrupted"
        assert json.loads((tmp_path / "run" / "metrics.json").read_text())["scans"] == 21
        assert (tmp_path / "run" / "map.png").is_file()
    else:
        assert ended.returncode == -number


def test_a_run_cut_between_two_files_is_still_measured(tmp_path: Path) -> None:
    write_run(tmp_path)
    for name in ("odometry.tum", "steps.csv"):
        lines = (tmp_path / name).read_text().splitlines(keepends=True)
        (tmp_path / name).write_text("".join(lines[:-3]))
    assert measure(tmp_path)["scans"] == 47


def test_a_run_without_a_step_is_measured(tmp_path: Path) -> None:
    for name in ("trajectory.tum", "odometry.tum"):
        (tmp_path / name).touch()
    (tmp_path / "steps.csv").write_text(",".join(STEP_COLUMNS) + "\n")
    assert measure(tmp_path) == {"scans": 0}


def test_a_failed_write_leaves_no_file(tmp_path: Path) -> None:
    path = tmp_path / "map.png"
    path.write_text("old")

    def interrupted() -> None:
        with atomic_file(path) as draft:
            draft.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_latest_is_not_overwritten_when_it_is_no_link(tmp_path: Path) -> None:
    (tmp_path / "latest").mkdir()
    with pytest.raises(InputError, match="is not a link"):
        make_run_folder("corridor", runs=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["latest"]
