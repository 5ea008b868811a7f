"""Every command as a user runs it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sim.robot import SimRobot
from slam.cli.main import main
from slam.errors import RobotError
from slam.robot import Observation
from slam.run import experiment_setup
from slam.scenario.file import load_scenario

CLOSED_FILES = {"map.json", "walls.geojson", "key_scans.npz", "graph.json", "closed.tum"}
ALL_FILES = {
    "config.yaml",
    "metrics.json",
    "trajectory.tum",
    "odometry.tum",
    "lines.geojson",
    "map.png",
    "errors.png",
    "steps.csv",
    "log.mcap",
}


def hopslam(*words: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", "from slam.cli.main import main; main()", *map(str, words)],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])},
    )


def hopslam_here(capsys: pytest.CaptureFixture[str], *words: str | Path) -> tuple[int, str, str]:
    """Exit code, output and errors of a command in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["hopslam", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            main()
    return int(ended.value.code or 0), *capsys.readouterr()


@pytest.mark.parametrize("group", ["sweep", "bench", "calibrate", "ros"])
def test_group_without_a_command_prints_its_help(group: str, capsys: pytest.CaptureFixture[str]) -> None:
    _, output, errors = hopslam_here(capsys, group)
    assert f" {group} [OPTIONS] COMMAND" in output + errors
    assert "Traceback" not in errors


def test_the_command_line_imports_no_numpy_early() -> None:
    code = "import slam.cli.main, sys; assert not {'numpy', 'numba', 'gymnasium', 'pydantic'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.fixture(scope="module")
def paper_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The paper's simulation, whole, with a recording for rerun."""
    folder = tmp_path_factory.mktemp("paper")
    done = hopslam("run", "paper_simulation", "--seed", "3", "--out", folder / "run", "--rerun", folder / "run.rrd")
    assert done.returncode == 0, done.stderr
    assert "ATE (rmse)" in done.stdout
    assert "arrived; results in" in done.stdout
    return folder / "run"


def test_a_run_folder_is_complete(paper_run: Path) -> None:
    assert {path.name for path in paper_run.iterdir()} == ALL_FILES | {"groundtruth.tum", "run.rrd"}
    for picture in ("map.png", "errors.png"):
        assert (paper_run / picture).read_bytes().startswith(b"\x89PNG")


def test_the_paper_simulation_is_as_good_as_the_paper_says(paper_run: Path) -> None:
    """Figs. 17 to 20: within 5 cm and 0.5 deg over 6 m, at most 1000 iterations, under 500 on average."""
    metrics = json.loads((paper_run / "metrics.json").read_text())
    assert metrics["seed"] == 3
    assert metrics["ending"] == "arrived"
    assert 5.7 < metrics["path_m"] < 6.3
    assert metrics["x_max_abs_m"] < 0.05
    assert metrics["y_max_abs_m"] < 0.05
    assert metrics["heading_max_abs_deg"] < 0.5
    assert metrics["iterations_mean"] < 500
    assert metrics["iterations_max"] <= 1000


def test_the_line_map_is_in_the_map_frame(paper_run: Path) -> None:
    features = json.loads((paper_run / "lines.geojson").read_text())["features"]
    ends = [point for feature in features for point in feature["geometry"]["coordinates"]]
    assert len(features) > 500
    assert all(-3.5 < x < 5.5 and -0.5 < y < 9.7 for x, y in ends)


def test_a_run_is_repeated_bit_by_bit_from_its_configuration(paper_run: Path, tmp_path: Path) -> None:
    """The configuration contains the seed; another process computes the same trajectory."""
    assert hopslam("run", paper_run / "config.yaml", "--out", tmp_path / "again").returncode == 0
    assert (tmp_path / "again" / "trajectory.tum").read_bytes() == (paper_run / "trajectory.tum").read_bytes()


def test_the_recording_is_complete(paper_run: Path) -> None:
    rerun = Path(sys.executable).with_name("rerun")
    for recording in (paper_run.with_suffix(".rrd"), paper_run / "run.rrd"):
        checked = subprocess.run([rerun, "rrd", "verify", recording], capture_output=True, text=True)
        assert checked.returncode == 0, checked.stderr


def test_the_default_folder_and_latest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert hopslam_here(capsys, "run", "paper_simulation", "--set", "duration=1")[0] == 0
    latest = tmp_path / "runs" / "latest"
    assert latest.is_symlink()
    assert json.loads((latest / "metrics.json").read_text())["ending"] == "duration over"


def test_the_corridor_is_mapped_where_dead_reckoning_bends(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, errors = hopslam_here(capsys, "run", "--out", tmp_path / "run")
    assert code == 0, errors
    metrics = json.loads((tmp_path / "run" / "metrics.json").read_text())
    assert load_scenario(tmp_path / "run" / "config.yaml").name == "corridor"
    assert metrics["ending"] == "arrived"
    assert metrics["path_m"] > 60
    assert metrics["odometry_final_m"] > 1.0
    assert metrics["final_m"] < metrics["odometry_final_m"] / 3
    assert metrics["ate_rmse_m"] < 0.1


def test_replay(tmp_path: Path, small_log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, output, errors = hopslam_here(capsys, "replay", small_log, "--out", tmp_path / "run")
    assert code == 0, errors
    assert "12 scans" in output
    assert {path.name for path in (tmp_path / "run").iterdir()} == ALL_FILES | CLOSED_FILES
    metrics = json.loads((tmp_path / "run" / "metrics.json").read_text())
    assert metrics["scans"] == 12
    assert metrics["path_m"] == pytest.approx(0.55, abs=0.05)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["run", "coridor"], "did you mean corridor?"),
        (["run", "paper_corridor", "--set", "slam.lines.psy=1"], "did you mean psi?"),
        (["run", "corridor", "--set", "physics.rate=241"], "physics.rate"),
        (["run", "corridor", "--seed", "-1"], "seed"),
        (["replay", "nowhere.log"], "nowhere.log"),
        (["run", "replay"], "the world is empty"),
        (["run", "paper_simulation", "--rerun", "my.log"], "--rerun my.log: give FILE.rrd"),
        (["run", "paper_simulation", "--rerun", "no/where.rrd"], "no/where.rrd: cannot be written"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(
    words: list[str],
    complaint: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, errors = hopslam_here(capsys, *words)
    assert code == 2
    assert complaint in errors
    assert errors.startswith("hopslam: ")
    assert errors.count("\n") == 1
    assert not (tmp_path / "runs").exists()


def test_a_log_without_a_scan_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "empty.log").write_text("# nothing\n")
    code, _, errors = hopslam_here(capsys, "replay", tmp_path / "empty.log")
    assert code == 2
    assert "empty.log" in errors


def hear_ctrl_c() -> None:
    """Enable SIGINT in a child whose parent ignores it, as a shell does for background jobs."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_ctrl_c_leaves_a_complete_folder_and_exit_code_130(tmp_path: Path) -> None:
    words = [
        sys.executable,
        "-c",
        "from slam.cli.main import main; main()",
        "run",
        "corridor",
        "--out",
        tmp_path / "run",
    ]
    running = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=hear_ctrl_c)
    trajectory = tmp_path / "run" / "trajectory.tum"
    while not trajectory.exists() or trajectory.stat().st_size < 1000:
        assert running.poll() is None
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=60)
    assert running.returncode == 130, err
    assert "interrupted; results in" in out
    assert {path.name for path in (tmp_path / "run").iterdir()} == ALL_FILES | CLOSED_FILES | {"groundtruth.tum"}


@pytest.mark.parametrize("words", [["--help"], ["run", "--help"], ["replay", "--help"]])
def test_help_has_examples(words: list[str]) -> None:
    shown = hopslam(*words)
    assert shown.returncode == 0
    assert len(words) == 1 or "Examples" in shown.stdout


class Interrupting:
    """An attribute that raises Ctrl-C while the class around it is created."""

    def __set_name__(self, owner: type, name: str) -> None:
        raise KeyboardInterrupt


def test_ctrl_c_during_a_constructor_is_not_an_input_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("slam.cli.main.app", lambda: type("Made", (), {"part": Interrupting()}))
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 130


def test_a_robot_that_fails_leaves_its_data_and_exit_code_3(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Broken(SimRobot):
        seen = 0

        def observe(self, timeout: float = 1.0) -> Observation | None:
            self.seen += 1
            if self.seen > 5:
                raise RobotError("lidar: no answer on /dev/ttyACM0; check the cable")
            return super().observe(timeout)

    monkeypatch.setattr(experiment_setup, "make_robot", lambda _, scenario, seed: Broken(scenario, seed))
    code, _, errors = hopslam_here(capsys, "run", "paper_simulation", "--out", tmp_path / "run")
    assert code == 3
    assert errors == "hopslam: lidar: no answer on /dev/ttyACM0; check the cable\n"
    metrics = json.loads((tmp_path / "run" / "metrics.json").read_text())
    assert metrics["ending"] == "failed"
    assert metrics["scans"] == 5
