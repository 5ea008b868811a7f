"""The use of Ray by a sweep, without a cluster."""

import json
import sys
from pathlib import Path

import pytest

from slam.errors import InputError
from slam.sweep.code_bundle import CodeBundle, version_difference, versions
from slam.sweep.make_plan import make_plan
from slam.sweep.ray_cluster import LOCAL, RayCluster, run_on_cluster


def test_a_machine_of_other_versions_runs_nothing(tmp_path: Path) -> None:
    job = next(make_plan(["paper_simulation"], {}).jobs())
    expected = versions() | {"numba": "0.1"}
    answer = json.loads(run_on_cluster(job.model_dump_json(), str(tmp_path / "runs"), False, expected))
    assert answer["versions"] == versions()
    assert version_difference(expected, answer["versions"]) == f"numba {versions()['numba']} instead of 0.1"
    assert not (tmp_path / "runs").exists()


def test_without_ray_the_command_that_installs_it_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(InputError, match=r"pip install 'hopslam\[cluster\]'"):
        RayCluster(LOCAL, 1, str(tmp_path), True)


def test_a_code_bundle_has_code_scenarios_and_job_files(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text("extends: paper_simulation\n")
    mine = tmp_path / "mine.yaml"
    mine.write_text("extends: base.yaml\n")
    bundle = CodeBundle(make_plan([str(mine)], {}).files())
    sent = bundle.folder / "sent" / tmp_path.relative_to("/")
    assert {path.name for path in sent.iterdir()} == {"base.yaml", "mine.yaml"}
    for name in ("slam/cli/main.py", "sim/robot.py", "scenarios/corridor.yaml", "assets"):
        assert (bundle.folder / name).exists()
    assert not list(bundle.folder.rglob("__pycache__"))
    bundle.close()
    assert not bundle.folder.exists()
