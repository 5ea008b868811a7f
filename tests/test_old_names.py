"""Modules that were moved are found under their old names, which are said to be old."""

import subprocess
import sys
import warnings
from importlib import import_module
from pathlib import Path

import pytest

from slam.named_code import find_code
from slam.old_names import MOVED


@pytest.mark.filterwarnings("ignore:.* is an old name")  # of the packages on the way to the module
@pytest.mark.parametrize("old", MOVED)
def test_old_module_is_found_and_said_to_be_old(old: str) -> None:
    sys.modules.pop(old, None)
    with warnings.catch_warnings(action="ignore"):  # of its packages, which may be old too
        import_module(old.rpartition(".")[0])
    with pytest.warns(FutureWarning, match=f"{old} is an old name: the module is {MOVED[old]} now"):
        module = import_module(old)
    new = import_module(MOVED[old])
    public = [name for name in vars(new) if not name.startswith("_")]
    assert all(getattr(module, name) is getattr(new, name) for name in public)


def test_place_of_old_module_is_read() -> None:
    sys.modules.pop("slam.run.logs.replay", None)
    place = "slam.run.logs.replay:ReplayRobot"
    with pytest.warns(FutureWarning, match=r"slam\.run\.replay_robot now"):
        code = find_code(place, (place,))
    assert code.__name__ == "ReplayRobot"


def test_module_of_old_package_is_found() -> None:
    sys.modules.pop("slam.run.scenario.wall", None)
    with pytest.warns(FutureWarning, match=r"the module is slam\.scenario\.wall now"):
        assert import_module("slam.run.scenario.wall").Wall is import_module("slam.scenario.wall").Wall


def test_current_names_warn_of_nothing(tmp_path: Path) -> None:
    words = "import slam.run.experiment, slam.sweep.sweep, slam.env.p3dx_env, sim, hardware.robot, slam.cli.main"
    done = subprocess.run([sys.executable, "-W", "error::FutureWarning", "-c", words], cwd=tmp_path, check=False)
    assert done.returncode == 0
