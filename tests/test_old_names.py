"""Old names stay valid: moved modules, commands, columns and keys."""

import json
import subprocess
import sys
import warnings
from importlib import import_module
from pathlib import Path

import pytest
from typer.main import get_command

from slam.cli.main import app
from slam.named_code import find_code
from slam.old_names import MOVED
from slam.run.experiment_setup import scenario_experiment
from slam.scenario.file import load_scenario


@pytest.mark.filterwarnings("ignore:.* is an old name")  # of the packages on the way to the module
@pytest.mark.parametrize("old", MOVED)
def test_an_old_module_is_imported_with_a_warning(old: str) -> None:
    sys.modules.pop(old, None)
    with warnings.catch_warnings(action="ignore"):  # of its packages, which may be old too
        import_module(old.rpartition(".")[0])
    with pytest.warns(FutureWarning, match=f"{old} is an old name: the module is {MOVED[old]} now"):
        module = import_module(old)
    new = import_module(MOVED[old])
    public = [name for name in vars(new) if not name.startswith("_")]
    assert all(getattr(module, name) is getattr(new, name) for name in public)


def test_the_file_of_an_old_module_is_found() -> None:
    sys.modules.pop("slam.run.logs.replay", None)
    place = "slam.run.logs.replay:ReplayRobot"
    with pytest.warns(FutureWarning, match=r"slam\.run\.replay_robot now"):
        code = find_code(place, (place,))
    assert code.__name__ == "ReplayRobot"


def test_module_of_old_package_is_found() -> None:
    sys.modules.pop("slam.run.scenario.wall", None)
    with pytest.warns(FutureWarning, match=r"the module is slam\.scenario\.wall now"):
        assert import_module("slam.run.scenario.wall").Wall is import_module("slam.scenario.wall").Wall


def test_current_names_give_no_warning(tmp_path: Path) -> None:
    words = "import slam.run.experiment, slam.sweep.sweep, slam.env.p3dx_env, sim, hardware.robot, slam.cli.main"
    done = subprocess.run([sys.executable, "-W", "error::FutureWarning", "-c", words], cwd=tmp_path, check=False)
    assert done.returncode == 0


COMMANDS = {
    "": "animate bench calibrate compare doctor emulate env eval export lines localize replay report run schema sweep "
    "view world",
    "sweep": "repeat report run",
    "calibrate": "square",
    "bench": "hardware lines localize match paper sim slam slam-sim start sweep viewer",
}
STEP_COLUMNS = (
    "stamp,mapped,iterations,converged,map_points,segments,extraction_ms,slam_ms,v,omega,lost,"
    "cov_xx,cov_xy,cov_xth,cov_yy,cov_yth,cov_thth"
)
METRICS = (
    "ate_max_m ate_rmse_m began duration_s ending extraction_ms_median final_m heading_final_deg heading_max_abs_deg "
    "heading_rmse_deg iterations_max iterations_mean map_points not_converged odometry_ate_max_m odometry_ate_rmse_m "
    "odometry_final_m odometry_heading_final_deg odometry_heading_max_abs_deg odometry_heading_rmse_deg "
    "odometry_x_max_abs_m odometry_y_max_abs_m path_m real_time_factor scans seed segments slam_ms_median slam_ms_p99 "
    "slam_s_total updates version x_max_abs_m y_max_abs_m"
)
MAP_KEYS = {
    "robot": "T_map_added T_map_base T_map_mapped T_map_matched T_odom_base covariance growth misfits tile",
    "directions": "clusters total",
    "grid": "cell cells corner free shape surfels",
}


@pytest.mark.parametrize("group", COMMANDS)
def test_the_commands_of_version_0_1_exist(group: str) -> None:
    command = get_command(app)
    command = command.commands[group] if group else command
    assert set(COMMANDS[group].split()) <= set(command.commands)


def test_files_of_a_run_have_the_names_of_version_0_1(tmp_path: Path) -> None:
    folder = scenario_experiment(load_scenario("corridor", ["duration=1"])).run(tmp_path / "run").folder
    assert (folder / "steps.csv").read_text().startswith(STEP_COLUMNS)
    assert set(METRICS.split()) <= set(json.loads((folder / "metrics.json").read_text()))
    saved = json.loads((folder / "map.json").read_text())
    assert all(set(names.split()) <= set(saved[key]) for key, names in MAP_KEYS.items())
