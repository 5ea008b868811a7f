"""Scores compared with those of evo and of the shared script, and the commands that print them."""

import importlib.util
import json
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from typer.testing import CliRunner

from slam.cli.main import app
from slam.errors import InputError, LogError
from slam.files.tum import format_tum
from slam.pose import FloatArray, Pose2D
from slam.run.results.recorder import STEP_COLUMNS
from slam.run.scoring.evaluate import Delta, against_reference, against_relations, statistics
from slam.run.scoring.pose_errors import Trajectory, absolute_errors, errors_by_frames, read_relations

SCRIPT = Path(__file__).parents[1] / "../shared/tools/evaluate.py"
STAMPS = 0.5 * np.arange(80)
RELATIONS = "1.0 4.25 0.9 0.1 0 0 0 0.3\n2 30 3 0.5 0 0 0 -0.4\n10 99 1 0 0 0 0 0\n"


def wander(seed: int) -> FloatArray:
    return np.cumsum(np.random.default_rng(seed).normal([[0.4, 0.1, 0.05]], 0.05, (80, 3)), axis=0)


TRUTH = wander(0)
ESTIMATE = TRUTH + np.random.default_rng(1).normal(0.0, 0.05, (80, 3))


def write_tum(path: Path, poses: FloatArray) -> Path:
    rows = zip(STAMPS, poses.tolist(), strict=True)
    path.write_text("".join(format_tum(stamp, Pose2D(*pose)) + "\n" for stamp, pose in rows))
    return path


@pytest.mark.filterwarnings("ignore")  # evo's imports
@pytest.mark.parametrize("align", [True, False])
def test_the_absolute_error_is_evo_s(tmp_path: Path, align: bool) -> None:
    from evo.core.metrics import APE, PoseRelation
    from evo.tools.file_interface import read_tum_trajectory_file

    truth, estimate = (read_tum_trajectory_file(write_tum(tmp_path / n, p)) for n, p in (("t", TRUTH), ("e", ESTIMATE)))
    if align:
        estimate.align(truth)
    mine = absolute_errors(ESTIMATE, TRUTH, align)
    relations = ((PoseRelation.translation_part, mine.metres), (PoseRelation.rotation_angle_rad, mine.radians))
    for relation, errors in relations:
        ape = APE(relation)
        ape.process_data((truth, estimate))
        theirs = ape.get_all_statistics()
        for name, value in statistics(errors).items():
            assert value == pytest.approx(theirs[name], abs=2e-6)


@pytest.mark.filterwarnings("ignore")  # evo's imports
@pytest.mark.parametrize("frames", [1, 7])
def test_the_relative_error_is_evo_s(tmp_path: Path, frames: int) -> None:
    from evo.core.metrics import RPE, PoseRelation, Unit
    from evo.tools.file_interface import read_tum_trajectory_file

    truth, estimate = (read_tum_trajectory_file(write_tum(tmp_path / n, p)) for n, p in (("t", TRUTH), ("e", ESTIMATE)))
    mine = errors_by_frames(ESTIMATE, TRUTH, frames)
    relations = ((PoseRelation.translation_part, mine.metres), (PoseRelation.rotation_angle_rad, mine.radians))
    for relation, errors in relations:
        rpe = RPE(relation, frames, Unit.frames, all_pairs=True)
        rpe.process_data((truth, estimate))
        np.testing.assert_allclose(errors, rpe.error, atol=3e-6)


@pytest.fixture(scope="module")
def script() -> ModuleType:
    if not SCRIPT.is_file():
        pytest.skip(f"no {SCRIPT}")
    spec = importlib.util.spec_from_file_location("evaluate", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.filterwarnings("ignore")  # the script leaves the file of the relations open
def test_all_scores_are_those_of_the_shared_script(script: ModuleType, tmp_path: Path) -> None:
    shifted = STAMPS + 0.2
    theirs = script.ate_rpe(STAMPS, ESTIMATE, shifted, TRUTH)
    for length in (1.0, 10.0):
        estimate, reference = Trajectory(STAMPS, ESTIMATE), Trajectory(shifted, TRUTH)
        absolute, relative = against_reference(estimate, reference, Delta(length), True, 1.0)
        assert len(absolute.errors.metres) == theirs["matched"]
        assert statistics(absolute.errors.metres)["rmse"] == pytest.approx(theirs["ate_rmse_m"])
        assert np.degrees(statistics(absolute.errors.radians)["rmse"]) == pytest.approx(theirs["heading_rmse_deg"])
        key = f"rpe{length:.0f}m"
        assert relative.asked == theirs[f"{key}_pairs"]
        assert statistics(relative.errors.metres)["rmse"] == pytest.approx(theirs[f"{key}_trans_rmse"])
        assert np.degrees(statistics(relative.errors.radians)["rmse"]) == pytest.approx(theirs[f"{key}_rot_rmse_deg"])
    (tmp_path / "relations").write_text(RELATIONS)
    known = script.kuemmerle(STAMPS, ESTIMATE, str(tmp_path / "relations"))
    mine = against_relations(Trajectory(STAMPS, ESTIMATE), tmp_path / "relations", 1.0)
    assert (mine.asked, len(mine.errors.metres)) == (known["relations"], known["used"]) == (3, 2)
    for values, other in ((mine.errors.metres, known["trans_m"]), (np.degrees(mine.errors.radians), known["rot_deg"])):
        assert {name: statistics(values)[name] for name in other} == pytest.approx(other)


def test_a_file_is_scored(tmp_path: Path) -> None:
    estimate, truth = write_tum(tmp_path / "e.tum", ESTIMATE), write_tum(tmp_path / "t.tum", TRUTH)
    (tmp_path / "r").write_text(RELATIONS)
    done = CliRunner().invoke(
        app, ["eval", str(estimate), "--reference", str(truth), "--relations", str(tmp_path / "r")]
    )
    assert done.exit_code == 0, done.output
    rmse = statistics(absolute_errors(ESTIMATE, TRUTH).metres)["rmse"]
    assert f"{rmse:.4f}" in next(line for line in done.output.splitlines() if line.startswith("ATE, aligned [m]"))
    as_json = CliRunner().invoke(app, ["eval", str(estimate), "--reference", str(truth), "--json"])
    assert json.loads(as_json.output)["ATE, aligned"]["metres"]["rmse"] == pytest.approx(rmse, abs=1e-6)
    assert "2 of 3" in next(line for line in done.output.splitlines() if line.startswith("relations [deg]"))


def test_runs_are_compared(tmp_path: Path) -> None:
    row = ",".join("0" * len(STEP_COLUMNS)) + "\n"
    for name, error in (("a", 0.5), ("b", 0.25)):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "config.yaml").write_text("name: a\n")
        (folder / "steps.csv").write_text(",".join(STEP_COLUMNS) + "\n" + 80 * row)
        for file in ("trajectory", "odometry"):
            write_tum(folder / f"{file}.tum", TRUTH)
        (folder / "metrics.json").write_text(json.dumps({"ate_rmse_m": error, "ending": "arrived"}))
    done = CliRunner().invoke(app, ["compare", str(tmp_path / "a"), str(tmp_path / "b")])
    assert done.exit_code == 0, done.output
    assert done.output.splitlines()[2].split() == ["ate_rmse_m", "0.5", "0.25", "(/", "2)"]
    as_json = CliRunner().invoke(app, ["compare", str(tmp_path / "a"), str(tmp_path / "b"), "--json"])
    assert [run["ate_rmse_m"] for run in json.loads(as_json.output).values()] == [0.5, 0.25]


def test_runs_that_cannot_be_scored_are_refused(tmp_path: Path) -> None:
    (tmp_path / "bad").write_text("1 2 3\n")
    file = write_tum(tmp_path / "e.tum", ESTIMATE)
    for words, complaint in (
        (["eval", str(file)], "has no true trajectory; give --reference"),
        (["compare", str(file)], "give two runs or more"),
        (["eval", str(file), "--delta", "0.5", "--delta-unit", "frames"], "give --delta 1 or more"),
    ):
        assert complaint in str(CliRunner().invoke(app, words).exception)
    with pytest.raises(LogError, match="bad: line 1: 3 numbers; need t1 t2"):
        read_relations(tmp_path / "bad")
    far = Trajectory(STAMPS + 1e6, TRUTH)
    with pytest.raises(InputError, match="share 0 stamps"):
        against_reference(Trajectory(STAMPS, ESTIMATE), far, Delta(), True, 1.0)
