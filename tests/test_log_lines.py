"""``hopslam lines`` and ``hopslam bench``: their files and their error messages."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from slam.cli.main import app
from slam.errors import InputError
from slam.files.logs import read_log
from slam.lidars import LIDARS
from slam.lines.extraction import extract_segments
from slam.lines.learnt_noise import LearntNoise
from slam.run.log_lines import (
    CSV_COLUMNS,
    CSV_HEADER,
    METHODS,
    Outputs,
    chosen_scans,
    csv_lines,
    geojson_features,
    line_config,
    write_lines,
)


def hopslam(*words: str | Path) -> Result:
    """A command in this process, whose errors stay exceptions."""
    return CliRunner().invoke(app, list(map(str, words)))


@pytest.mark.parametrize("method", METHODS)
def test_a_csv_file_reads_back_as_the_same_segments(small_log: Path, method: str) -> None:
    segments = extract_segments(read_log(small_log).scan(3), line_config(method, None))
    rows = list(csv.DictReader(io.StringIO(CSV_HEADER + csv_lines(3, segments))))
    assert len(rows) == len(segments) > 0
    assert tuple(rows[0]) == CSV_COLUMNS
    for names, expected in (
        (("start_x", "start_y"), segments.start),
        (("end_x", "end_y"), segments.end),
        (("rho", "theta"), np.column_stack([segments.rho, segments.theta])),
        (("scan", "beams"), np.column_stack([np.full(len(segments), 3), segments.counts])),
    ):
        np.testing.assert_allclose([[float(row[name]) for name in names] for row in rows], expected, rtol=1e-8)
    if segments.covariance is None:
        assert {row[name] for row in rows for name in CSV_COLUMNS[8:]} == {""}
    else:
        found = [[float(row[name]) for name in CSV_COLUMNS[8:]] for row in rows]
        np.testing.assert_allclose(found, segments.covariance[:, [0, 1, 0], [0, 1, 1]], rtol=1e-8)


def test_the_walls_of_the_small_log_are_found(small_log: Path) -> None:
    """A passage 4 m wide that ends 3 m ahead: three lines, their normals away from the sensor."""
    segments = extract_segments(read_log(small_log).scan(0), line_config("chi_square", None))
    np.testing.assert_allclose(segments.rho, [2.0, 3.0, 2.0], atol=0.002)
    np.testing.assert_allclose(segments.theta, [-np.pi / 2, 0.0, np.pi / 2], atol=0.002)


def test_geojson_has_the_same_segments_as_csv(small_log: Path) -> None:
    segments = extract_segments(read_log(small_log).scan(0), line_config("chi_square", None))
    features = list(geojson_features(7, segments))
    assert [feature["geometry"]["coordinates"][0] for feature in features] == segments.start.tolist()
    assert {"scan", *CSV_COLUMNS[5:]} == set(features[0]["properties"])
    assert features[0]["properties"]["var_rho"] > 0


def test_lines_of_all_scans_on_the_standard_output(small_log: Path) -> None:
    done = hopslam("lines", small_log)
    assert done.exit_code == 0, done.output
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    assert {int(row["scan"]) for row in rows} == set(range(12))
    assert "12 scans" in done.stderr
    assert f"{len(rows)} segments in 12 scans" in done.stderr


def test_noise_is_learned_from_scan_to_scan(small_log: Path, tmp_path: Path) -> None:
    log, config, noise = read_log(small_log), line_config("chi_square", None), LearntNoise.start()
    write_lines(log, range(12), config, Outputs(csv=tmp_path / "lines.csv"))
    learnt = [noise.observe(log.scan(index)) for index in range(12)]
    expected = "".join(csv_lines(k, extract_segments(log.scan(k), config, learnt[k])) for k in range(12))
    assert (tmp_path / "lines.csv").read_text() == CSV_HEADER + expected


def test_lines_of_one_scan_in_files(small_log: Path, tmp_path: Path) -> None:
    files = {name: tmp_path / f"lines.{name}" for name in ("csv", "geojson", "png")}
    options = [word for name, path in files.items() for word in (f"--{name}", path)]
    done = hopslam("lines", small_log, "--scan", "5", "--method", "paper", *options)
    assert done.exit_code == 0, done.output
    assert done.stdout == ""
    rows = files["csv"].read_text().splitlines()[1:]
    assert rows
    assert all(row.startswith("5,") for row in rows)
    assert len(json.loads(files["geojson"].read_text())["features"]) == len(rows)
    assert files["png"].read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--scan", "12"], "no scan 12 in this log; choose one from 0 to 11"),
        (["--method", "magic"], "no method named 'magic'; choose one of paper, chi_square"),
        (["--sensor", "sonar"], f"no sensor named 'sonar'; choose one of {', '.join(LIDARS)}"),
        (["--method", "paper", "--sensor", "urg04lx"], "leave one of them out"),
        (["--png", "all.png"], "a picture shows one scan; give --scan K"),
        (["--scan", "3", "--png", "a.txt"], "a.txt: a picture needs a name that ends in"),
        (["--csv", "nowhere/lines.csv"], "nowhere/lines.csv: cannot be written"),
    ],
)
def test_impossible_options_are_errors_of_one_line(
    small_log: Path, tmp_path: Path, words: list[str], complaint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    failed = hopslam("lines", small_log, *words)
    assert isinstance(failed.exception, InputError)
    assert failed.exception.exit_code == 2
    assert complaint in str(failed.exception)
    assert "\n" not in str(failed.exception)


def test_a_scan_is_chosen_by_its_number(small_log: Path) -> None:
    log = read_log(small_log)
    assert list(chosen_scans(log, 4)) == [4]
    assert len(chosen_scans(log, None)) == 12
    with pytest.raises(InputError):
        chosen_scans(log, -1)
    with pytest.raises(InputError, match="give --scan"):
        write_lines(log, range(2), line_config("paper", None), Outputs(png=Path("x.png")))


@pytest.mark.parametrize("words", [["lines"], ["bench", "paper"], ["bench", "lines"]])
def test_help_has_examples(words: list[str]) -> None:
    shown = hopslam(*words, "--help")
    assert shown.exit_code == 0
    assert "Examples" in shown.stdout


def test_bench_lines_prints_a_table(tmp_path: Path) -> None:
    pytest.importorskip("skimage")
    pytest.importorskip("cv2")
    done = hopslam("bench", "lines", "--seeds", "1", "--out", tmp_path / "lines.md")
    assert done.exit_code == 0, done.output
    text = (tmp_path / "lines.md").read_text()
    assert text.count("| split-and-merge |") == 3
    assert "seeds 1000 to 1000" in text


def test_bench_lines_reads_a_log(small_log: Path) -> None:
    pytest.importorskip("skimage")
    pytest.importorskip("cv2")
    done = hopslam("bench", "lines", "--log", small_log)
    assert done.exit_code == 0, done.output
    assert "12 of 12 scans, 181 beams each" in done.stdout
    assert "RANSAC" in done.stdout


def test_bench_paper_prints_its_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("skimage")
    monkeypatch.setattr("slam.bench.paper.report.QUICK_TRIALS", 3)
    monkeypatch.setattr("slam.bench.paper.report.QUICK_DURATION", 2.0)
    done = hopslam("bench", "paper", "--quick", "--out", tmp_path / "paper")
    assert done.exit_code == 0, done.output
    assert "380 nearly collinear points" in done.stdout
    assert (tmp_path / "paper" / "fig_8.png").is_file()
