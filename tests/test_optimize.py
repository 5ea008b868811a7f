"""Loops of a finished run, closed again."""

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from slam.cli.main import app
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.run.experiment_setup import continue_mapping, replay_experiment
from slam.run.optimize import Optimization
from slam.run.results.run_record import RunRecord
from slam.scenario.file import load_scenario

CLOSED = ("closed.tum", "graph.json", "map.json", "map.png", "errors.png")
ON_THE_WAY = ("config.yaml", "log.mcap", "trajectory.tum", "odometry.tum", "steps.csv", "lines.geojson")


@pytest.fixture
def copy(lap_run: Path, tmp_path: Path) -> Path:
    return shutil.copytree(lap_run, tmp_path / "run")


def optimize(folder: Path, *settings: str, out: Path | None = None) -> Path:
    scenario = load_scenario(folder / "config.yaml", settings)
    return Optimization(RunRecord.open(folder), scenario, list(settings)).run(out, Terminal(quiet=True))[0]


def metrics_of(folder: Path) -> dict[str, object]:
    metrics: dict[str, object] = json.loads((folder / "metrics.json").read_text())
    return {key: value for key, value in metrics.items() if key not in ("closing_s", "optimized")}


def assert_same(folder: Path, lap_run: Path) -> None:
    """Check that the folder has the same files as the run, except for the time that the closing took."""
    assert sorted(path.name for path in folder.iterdir()) == sorted(path.name for path in lap_run.iterdir())
    for name in CLOSED + ON_THE_WAY:
        assert (folder / name).read_bytes() == (lap_run / name).read_bytes(), name
    assert metrics_of(folder) == metrics_of(lap_run)


def test_the_same_settings_give_the_same_files(lap_run: Path, tmp_path: Path) -> None:
    assert_same(optimize(lap_run, out=tmp_path / "out"), lap_run)


def test_other_settings_change_only_closed_files(lap_run: Path, tmp_path: Path) -> None:
    folder = optimize(lap_run, "slam.map.cell=0.25", out=tmp_path / "out")
    for name in ON_THE_WAY:
        assert (folder / name).read_bytes() == (lap_run / name).read_bytes(), name
    record = RunRecord.open(folder)
    assert (folder / "closed.tum").read_bytes() != (lap_run / "closed.tum").read_bytes()
    assert record.saved_map is not None
    assert record.saved_map.mapper.map.config.cell == 0.25
    assert record.metrics is not None
    assert record.metrics["optimized"] == ["slam.map.cell=0.25"]
    assert optimize(folder) == folder
    assert_same(folder, lap_run)


def test_a_killed_run_is_closed_up_to_its_end(copy: Path, lap_run: Path) -> None:
    for name in (*CLOSED, "metrics.json"):
        (copy / name).unlink()
    optimize(copy)
    assert (copy / "closed.tum").read_bytes() == (lap_run / "closed.tum").read_bytes()
    assert not RunRecord.open(copy).complete


def test_without_loops_no_file_is_changed(copy: Path, lap_run: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no loops are closed by these settings"):
        optimize(copy, "slam.loops=never", out=tmp_path / "out")
    experiment = continue_mapping(replay_experiment(copy, load_scenario("replay")), copy / "map.json", "saved")
    went_on = experiment.run(tmp_path / "on", pictures=False).folder
    command = f"hopslam replay {went_on} --map {copy / 'map.json'} --start saved"
    with pytest.raises(InputError, match=f"whose scans are not in its log; .* {command}"):
        optimize(went_on)
    for path in went_on.iterdir():  # a run that was killed
        if path.name not in ON_THE_WAY:
            path.unlink()
    with pytest.raises(InputError, match=command):
        optimize(went_on)
    assert not (tmp_path / "out").exists()
    for path in lap_run.iterdir():
        assert (copy / path.name).read_bytes() == path.read_bytes()


def test_the_command_prints_its_result(copy: Path) -> None:
    (copy / "run.rrd").write_text("older")
    result = CliRunner().invoke(app, ["optimize", str(copy)])
    assert result.exit_code == 0, result.output
    assert "loops" in result.output
    assert "believed" in result.output
    assert not (copy / "run.rrd").exists()
