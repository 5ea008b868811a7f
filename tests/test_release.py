"""The wheel and the source distribution contain all that hopslam needs, and no more."""

import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from collections.abc import Callable
from email import message_from_string
from pathlib import Path

import pytest
import yaml

pytest.importorskip("hatchling", reason="make test installs it: pip install hatchling")
ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a wheel and a source distribution, made as ``make release`` makes them."""
    folder = tmp_path_factory.mktemp("dist")
    build = [sys.executable, "-m", "hatchling", "build", "--target", "sdist", "--target", "wheel", "--directory"]
    subprocess.run([*build, str(folder)], cwd=ROOT, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def in_empty_folder(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., str]:
    """Runs Python code with what the wheel holds, away from the checkout; gives back what it prints."""
    site, empty = tmp_path_factory.mktemp("site"), tmp_path_factory.mktemp("empty")
    zipfile.ZipFile(next(built.glob("*.whl"))).extractall(site)

    def run(code: str, *arguments: str) -> str:
        env = {**os.environ, "PYTHONPATH": str(site)}
        command = [sys.executable, "-P", "-c", code, *arguments]
        return subprocess.run(command, cwd=empty, env=env, check=True, capture_output=True, text=True).stdout

    return run


def test_scenarios_come_with_the_wheel(in_empty_folder: Callable[..., str]) -> None:
    main = "from slam.cli.main import main; main()"
    assert "corridor" in in_empty_folder(main, "world", "corridor", "--out", "plan.png")


def test_the_robot_model_comes_with_the_wheel(in_empty_folder: Callable[..., str]) -> None:
    found = in_empty_folder("from slam.assets import asset; print(asset('urdf/p3dx.urdf').read_text())")
    assert found == (ROOT / "assets" / "urdf" / "p3dx.urdf").read_text() + "\n"


def test_the_wheel_names_its_dependencies(built: Path) -> None:
    with zipfile.ZipFile(next(built.glob("*.whl"))) as wheel:
        name = next(name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = message_from_string(wheel.read(name).decode())
    needs = [line for line in metadata.get_all("Requires-Dist", []) if "extra ==" not in line]
    assert metadata["Requires-Python"] == "<3.14,>=3.11"
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert "python_version < '3.12'" in next(line for line in needs if line.startswith("pybullet"))
    assert not [line for line in needs if line.startswith(("stable-baselines3", "ray", "opencv", "rclpy"))]


def test_the_wheel_marks_its_packages_as_typed(built: Path) -> None:
    with zipfile.ZipFile(next(built.glob("*.whl"))) as wheel:
        typed = {name.split("/")[0] for name in wheel.namelist() if name.endswith("/py.typed")}
    assert typed == {"hopslam", "sim", "slam", "hardware"}


def test_version_and_date_agree_in_all_files() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert citation["version"] == version
    assert f"\n## {version} - {citation['date-released']}\n" in (ROOT / "CHANGELOG.md").read_text()


def test_the_source_has_the_tests_and_no_runs(built: Path) -> None:
    with tarfile.open(next(built.glob("*.tar.gz"))) as source:
        folders = {name.split("/")[1] for name in source.getnames()}
    assert {"assets", "docs", "hardware", "scenarios", "sim", "slam", "tests"} <= folders
    assert not folders & {"runs", ".venv", "shared"}
