"""Runs as functions: they return the results of their folder and raise exceptions on errors."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import hopslam
from slam.errors import InputError
from slam.files.tum import read_tum
from slam.run.loop import Ending
from slam.run.results.run_record import RunRecord

SHORT = ("duration=1.5", "lidar.model=table1")
PNG = b"\x89PNG\r\n"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> hopslam.Run:
    folder = tmp_path_factory.mktemp("runs") / "a <b> & run"
    return hopslam.run("corridor", seed=3, settings=SHORT, out=folder, pictures=False)


def test_a_run_has_the_contents_of_its_folder(run: hopslam.Run) -> None:
    assert run.metrics == json.loads((run.folder / "metrics.json").read_text())
    assert run.metrics["seed"] == 3
    stamps, poses = read_tum(run.folder / "groundtruth.tum")
    assert np.array_equal(run.stamps, stamps)
    assert np.array_equal(run.truth, poses)
    assert run.ending == "duration over"
    assert run.walls.shape[1:] == (2, 2)
    assert len(run.trajectory) == len(run.estimate) == len(run.odometry) == run.metrics["scans"]


def test_an_opened_run_equals_the_original(run: hopslam.Run) -> None:
    opened = hopslam.Run.open(run.folder)
    assert (opened.metrics, opened.ending, repr(opened)) == (run.metrics, run.ending, repr(run))
    (run.folder / "metrics.json").rename(run.folder / "kept.json")
    try:
        killed = hopslam.Run.open(run.folder)
        assert killed.ending is None
        assert killed.metrics["scans"] == run.metrics["scans"]
        assert "cut off" in killed._repr_html_()
    finally:
        (run.folder / "kept.json").rename(run.folder / "metrics.json")


def test_a_run_has_a_picture_and_escapes_its_name(run: hopslam.Run) -> None:
    page = run._repr_html_()
    assert (run._repr_png_() or b"").startswith(PNG)
    assert "a &lt;b&gt; &amp; run" in page
    assert "<b> &" not in page
    assert "ATE, rmse" in page


def test_a_replayed_run_has_the_same_score(run: hopslam.Run, tmp_path: Path) -> None:
    again = hopslam.replay(run.folder, out=tmp_path / "again", pictures=False)
    assert np.array_equal(again.estimate, run.estimate)
    scores, others = hopslam.evaluate(run, delta=0.1), hopslam.evaluate(str(again.folder), run.folder, delta=0.1)
    assert scores["ATE, aligned"].metres["rmse"] < 0.02
    assert len(others.scores) == len(scores.scores)
    with pytest.raises(KeyError, match="there are ATE, aligned"):
        scores["APE"]
    assert "<th>rmse</th>" in scores._repr_html_()
    assert repr(scores).startswith("Evaluation(ATE, aligned 0.0")


def test_a_score_is_the_known_displacement(run: hopslam.Run) -> None:
    class Shifted:
        stamps = run.stamps
        trajectory = run.truth + np.array([3.0, 4.0, 0.0])

    score = hopslam.evaluate(Shifted, run.folder / "groundtruth.tum", align=False, delta=0.1)["ATE"]
    assert score.metres == pytest.approx({"mean": 5.0, "std": 0.0, "rmse": 5.0, "median": 5.0, "max": 5.0}, abs=1e-5)
    assert score.radians["max"] == pytest.approx(0.0, abs=1e-6)


def test_the_report_and_the_exports_are_written(run: hopslam.Run, tmp_path: Path) -> None:
    assert run.report(tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")
    run.export("csv", tmp_path / "run.csv")
    assert (tmp_path / "run.csv").is_file()


def test_settings_reach_the_run(tmp_path: Path) -> None:
    config = hopslam.SlamConfig(mode="paper")
    made = hopslam.run(settings=SHORT, slam=config, out=tmp_path / "paper", pictures=False)
    assert RunRecord.open(made.folder).config.slam == config
    with pytest.raises(hopslam.InputError, match="give a SlamConfig"):
        hopslam.run(slam="paper")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scenario": "coridor"}, "did you mean corridor"),
        ({"settings": "duratoin=1"}, "duration"),
        ({"seed": 1.5}, "seed"),
        ({"saved_map": "nowhere.json"}, r"nowhere\.json: cannot be read"),
        ({"dry_run": True}, "for the real robot"),
        ({"backend": "replay"}, "no log to play"),
    ],
)
def test_a_wrong_argument_is_named_before_the_run_starts(
    arguments: dict[str, object], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(hopslam.InputError, match=message):
        hopslam.run(**arguments)
    assert not list(tmp_path.iterdir())


def test_a_failed_run_raises_and_keeps_its_results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    Path("tired.py").write_text(
        "from slam.config import ChiSquareConfig\n"
        "from slam.lines.extraction import extract_segments\n"
        "def lines(scan):\n"
        "    if scan.stamp > 1.0:\n"
        "        raise ValueError('no more')\n"
        "    return extract_segments(scan, ChiSquareConfig())\n"
    )
    settings = (*SHORT, "slam.lines.method=tired:lines")
    with pytest.raises(hopslam.InputError, match="no more") as raised:
        hopslam.run(settings=settings, out="first", pictures=False)
    assert raised.value.__notes__ == ["what was done is in first"]
    made = hopslam.run(settings=settings, out="second", pictures=False, check=False)
    assert (made.ending, type(made.error)) == ("failed", hopslam.InputError)
    assert (made._repr_png_() or b"").startswith(PNG)
    assert "failed" in made._repr_html_()


@pytest.mark.parametrize(("ending", "raises"), [("interrupted", KeyboardInterrupt), ("arrived", None)])
def test_only_an_interrupted_run_is_a_keyboard_interrupt(ending: Ending, raises: type | None) -> None:
    run = hopslam.Run(Path("runs/x"), ending, {"scans": 0})
    if raises is None:
        run.require_success()
    else:
        with pytest.raises(raises, match="runs/x"):
            run.require_success()


def test_a_questionable_scenario_gives_a_python_warning(tmp_path: Path) -> None:
    strange = ("route.speed=0.5", "robot.limits.linear=0.4")
    with pytest.warns(UserWarning, match=r"route\.speed"):
        hopslam.run(settings=(*SHORT, *strange), out=tmp_path / "run", pictures=False)


def test_a_script_without_a_main_guard_can_sweep(tmp_path: Path) -> None:
    """The workers do not run the user's script once more."""
    script = tmp_path / "script.py"
    script.write_text(
        "import hopslam, numpy\n"
        "print('started', flush=True)\n"
        f"sweep = hopslam.sweep('corridor', seeds=range(2), settings={SHORT!r}, out='sweep', jobs=1,\n"
        "    grid={'slam.matching.floor': numpy.array([0.01])}, sample={'robot.start.y': 'uniform(-0.1, 0.1)'})\n"
        "print(sweep.done, sweep.failed, sorted(row['seed'] for row in sweep.rows(['seed', 'status'])))\n"
        "again = hopslam.sweep('sweep/sweep.yaml', out='sweep')\n"
        "print(again.done, again.before, 'ate_rmse_m' in again._repr_html_())\n"
    )
    said = subprocess.run([sys.executable, script], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert said.splitlines() == ["started", "2 0 [0, 1]", "0 2 True"]


def test_a_robot_is_localized_in_the_map_of_a_run(run: hopslam.Run, tmp_path: Path) -> None:
    found = hopslam.localize(run.folder, run.folder / "map.json", out=tmp_path / "found", pictures=False)
    assert "sure_after_s" in found.metrics
    with pytest.raises(hopslam.InputError, match="nothing is random"):
        hopslam.localize(run.folder, run.folder / "map.json", seed=3)


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: hopslam.run(None), "scenario: expected a name or a path"),
        (lambda: hopslam.run("corridor", settings=None), "a list of strings"),
        (lambda: hopslam.run("corridor", settings=[5]), "a list of strings"),  # type: ignore[list-item]
        (lambda: hopslam.run("corridor", out=5), "out: expected a path"),
        (lambda: hopslam.replay(None), "log: expected a path"),
        (lambda: hopslam.localize(None, "map.json"), "source: expected a path"),
        (lambda: hopslam.sweep(None), "a list of strings"),
        (lambda: hopslam.evaluate(None), "the path of a run folder or a TUM file"),
    ],
)
def test_a_wrong_type_of_argument_is_named(call: Callable[[], object], named: str) -> None:
    with pytest.raises(InputError, match=named):
        call()
