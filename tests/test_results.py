"""What a run leaves behind: readable at every moment, and measured as the field measures."""

import json
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from slam.errors import InputError
from slam.pose import Pose2D
from slam.run.logs.tum import format_tum
from slam.run.results.files import GrowingGeoJson, write_whole
from slam.run.results.metrics import measure
from slam.run.results.recorder import STEP_COLUMNS
from slam.run.results.run_folder import make_run_folder


def test_a_whole_file_replaces_the_old_one_and_leaves_no_draft(tmp_path: Path) -> None:
    path = tmp_path / "metrics.json"
    for text in ("old", "new"):
        write_whole(path, text)
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


def test_a_folder_that_holds_something_is_not_written_to(tmp_path: Path) -> None:
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
    row = "0.0,1,7,1,100,3,0.1,2.5,0.5,0.0\n"
    (folder / "steps.csv").write_text(",".join(STEP_COLUMNS) + "\n" + 50 * row)


@pytest.mark.filterwarnings("ignore")  # evo's imports
def test_the_errors_are_those_that_evo_finds(tmp_path: Path) -> None:
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


def test_metrics_have_all_that_is_promised(tmp_path: Path) -> None:
    write_run(tmp_path)
    errors = ("ate_rmse_m", "ate_max_m", "x_max_abs_m", "y_max_abs_m", "heading_max_abs_deg", "heading_rmse_deg")
    work = ("scans", "duration_s", "path_m", "iterations_mean", "iterations_max", "slam_ms_median", "slam_ms_p99")
    more = ("extraction_ms_median", "map_points", "segments")
    assert {*errors, *(f"odometry_{name}" for name in errors), *work, *more} <= measure(tmp_path).keys()


KILLED = """
    import os, sys
    from slam.run import experiment
    from slam.run.scenario.file import load_scenario
    from pathlib import Path

    class Assassin:
        def __init__(self, *_): pass
        def __enter__(self): return self
        def __exit__(self, *_): pass
        def see(self, step):
            if step.index == 20:
                os.kill(os.getpid(), {signal})

    experiment.RunProgress = Assassin
    outcome = experiment.scenario_experiment(load_scenario("paper_simulation")).run(Path(sys.argv[1]))
    print(outcome.ending)
"""


@pytest.mark.parametrize("name", ["SIGKILL", "SIGINT"])
def test_what_was_done_survives(name: str, tmp_path: Path) -> None:
    number = getattr(signal, name)
    code = textwrap.dedent(KILLED).format(signal=int(number))
    ended = subprocess.run([sys.executable, "-c", code, tmp_path / "run"], capture_output=True, text=True)
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


def test_a_run_without_a_step_is_measured_as_such(tmp_path: Path) -> None:
    for name in ("trajectory.tum", "odometry.tum"):
        (tmp_path / name).touch()
    (tmp_path / "steps.csv").write_text(",".join(STEP_COLUMNS) + "\n")
    assert measure(tmp_path) == {"scans": 0}
