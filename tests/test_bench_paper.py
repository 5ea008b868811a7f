"""The figures of the paper measured again: its formulas by hand, and results that do not depend on time."""

import re
import sys
from math import cos, degrees, radians
from pathlib import Path

import numpy as np
import pytest

from slam.bench.paper import fig_3, fig_7, fig_8, fig_10, fig_21, table_2, tables
from slam.bench.paper.report import reproduce
from slam.bench.paper.table_2 import hops, predicted_speed_up
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.lidars import TABLE1
from slam.lines.hopping import segments_by_hopping
from slam.scenario.file import load_scenario


def test_every_equation_is_cited_beside_the_code() -> None:
    """Eqs. (1) to (44) by their own numbers, not only inside a range such as (38)-(44)."""
    cited: set[int] = set()
    for path in (Path(__file__).parents[1] / "slam").rglob("*.py"):
        for numbers in re.findall(r"[Ee]qs?\. \(\d+\)(?:(?:, | and )\(\d+\))*(?![-\d])", path.read_text()):
            cited.update(map(int, re.findall(r"\d+", numbers)))
    assert set(range(1, 45)) - cited == set()


def test_hops_are_those_counted_by_hand() -> None:
    """Eq. (14)."""
    assert hops(10, 2) == (3, 3)
    assert hops(12, 2) == (3, 5)
    assert hops(12, 0) == (11, 11)


def test_the_predicted_speed_up_is_the_hand_calculation() -> None:
    """Eq. (13) with t(j) = j: 45 / (1 + 4 + 7), then 66 / (1 + 4 + 7 + 4 + 5)."""
    assert predicted_speed_up(10, 2) == 45 / 12
    assert predicted_speed_up(12, 2) == 66 / 21
    assert predicted_speed_up(12, 2, lambda points: 1.0) == 11 / 5
    assert predicted_speed_up(2280, 0) == 1.0


def test_a_wall_is_one_segment_of_the_predicted_tests() -> None:
    for psi in table_2.PSI:
        tests = len(table_2.tested_lengths(table_2.wall(table_2.POINTS // 10), table_2.SIGMA_TH, psi))
        assert tests == pytest.approx(hops(table_2.POINTS // 10, psi)[1], abs=psi + 1)


def test_hopping_changes_no_segment_but_the_tests() -> None:
    rows = {row.psi: row for row in fig_7.measure(trials=30)}
    assert all(row.different == 0 for row in rows.values())
    assert rows[0].tests > 2 * rows[5].tests
    assert rows[40].tests > 2 * rows[5].tests


def test_the_note_of_fig_7_describes_its_columns() -> None:
    rows = [fig_7.Fig7Row(0, 0, 80.0, 0), fig_7.Fig7Row(5, 0, 26.0, 3), fig_7.Fig7Row(40, 0, 87.0, 1)]
    notes = tables.figure_7(rows, 200).notes
    assert "none of 200 scans differs from those of psi = 0" in notes
    assert "with a threshold on that, up to 3 of 200 scans differ (last column)" in notes
    assert "with a threshold on that, none of 20 scans differs" in tables.figure_7(rows[:1], 20).notes


def test_fig_3_without_noise_is_the_plan_seen_from_its_pose() -> None:
    """(1 m, 1 m, 20 deg): walls of 10 cm stand on x = 0 and x = 2, so both are 0.95 m away."""
    result = fig_3.measure("none")
    assert result.T_map_laser.translation == pytest.approx([1.0, 1.0], abs=1e-6)
    assert degrees(result.phi) == pytest.approx(20.0, abs=1e-4)
    assert len(result.scan.ranges) == 128
    assert degrees(result.scan.angle_increment) == pytest.approx(1.875)
    half_a_step = TABLE1.resolution / 2.0
    for towards in (180.0, 0.0):  # in the map, degrees: to the left wall and to the right one
        off = result.scan.bearings - radians(towards - 110.0)
        beam = int(np.abs(off).argmin())
        assert result.scan.ranges[beam] == pytest.approx(0.95 / cos(off[beam]), abs=half_a_step + 1e-4)
    assert result.point_errors.max() < half_a_step + 1e-4
    assert result.segment_errors.max() < 2.0 * half_a_step
    normals = result.T_map_laser.theta + result.segments.theta
    assert np.abs(np.sin(2.0 * normals)).max() < 0.05  # every wall of the plan is parallel to x or y
    assert len(result.segments) == 5


def test_errors_of_fig_3_are_within_table_1() -> None:
    result = fig_3.measure()
    ranges = result.scan.ranges[result.scan.echoes]
    assert (result.point_errors < 4.0 / 3.0 * TABLE1.accuracy(ranges)).all()  # four standard deviations
    assert (result.point_errors > TABLE1.resolution).any()
    assert len(result.segments) >= 5


def test_the_share_of_fig_21_is_the_hand_calculation() -> None:
    """The paper's own numbers: 1302 of 1453.2 s."""
    extraction = {"svd_full": np.array([100.0, 50.0]), "svd": np.array([98.0, 0.0]), "prefix_sums": np.zeros(2)}
    result = fig_21.Fig21(scans=9, matching=np.array([302.0, 1000.0]), extraction=extraction, prediction=1.2)
    assert result.total("svd_full") == pytest.approx(1453.2)
    assert result.share("svd_full") == pytest.approx(fig_21.PAPER_SHARE)
    assert result.share("svd") == pytest.approx(1302.0 / 1401.2)
    assert result.share("prefix_sums") == pytest.approx(1302.0 / 1303.2)
    rows = [row[-1] for row in tables.figure_21(result).rows]
    assert rows == ["89.6 %", "92.9 %", "99.9 %", "89.6 %"]
    assert "2 of 9 scans were mapped" in tables.figure_21(result).notes


def test_fig_21_times_every_scan_of_the_drive() -> None:
    """In 3 s it drives 1.1 m (0.3 m/s^2 up to 0.5 m/s): the first scan is mapped, and one after every 25 to 30 cm."""
    result = fig_21.measure(3.0)
    assert result.scans == 30
    assert len(result.matching) == 4
    assert all(len(taken) == 4 for taken in result.extraction.values())
    assert (result.matching > 0.0).all()
    assert result.prediction > 0.0
    assert result.extraction["prefix_sums"].sum() < result.extraction["svd"].sum()
    assert all(0.0 < result.share(kernel) < 1.0 for kernel in fig_21.KERNELS)


def test_the_kernels_of_fig_21_find_the_same_segments() -> None:
    points, lines = fig_3.measure().scan.points(), load_scenario(fig_21.SCENARIO).slam.lines
    found = [segments_by_hopping(points, lines.model_copy(update={"kernel": kernel})) for kernel in fig_21.KERNELS]
    assert len(found[0]) > 0
    for other in found[1:]:
        np.testing.assert_array_equal([other.first, other.last], [found[0].first, found[0].last])


def test_hough_misses_the_short_wall_and_hopping_finds_it() -> None:
    """Fig. 8."""
    pytest.importorskip("skimage")
    result = fig_8.measure(repeats=1)
    counts = fig_8.lines_on_walls(result.hough.rho, result.hough.theta)
    assert counts["AB"] >= 1
    assert counts["BC"] == 0
    assert counts["CD"] >= 1
    lowered = fig_8.lines_on_walls(result.lowered.rho, result.lowered.theta)
    assert lowered["BC"] == 1
    assert lowered["AB"] + lowered["CD"] > 3
    assert len(result.segments) == 3
    ends = [wall[::-1] for wall in list(fig_8.WALLS.values())[::-1]]
    np.testing.assert_allclose(np.stack([result.segments.start, result.segments.end], axis=1), ends, atol=0.06)


def test_the_force_is_largest_at_its_peak() -> None:
    """Fig. 10: 3.68 cm, and 0.0246 m there."""
    assert fig_10.peak() == pytest.approx((0.5e-4) ** (1 / 3))
    assert fig_10.force(fig_10.peak()) == pytest.approx(1e-4 * 0.036840 / 1.5e-4, rel=1e-4)
    assert fig_10.force(fig_10.half_width()) == pytest.approx(0.5 * fig_10.force(fig_10.peak()))
    assert fig_10.force(-0.1) == -fig_10.force(0.1)


def test_the_report_has_its_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("skimage")
    monkeypatch.setattr("slam.bench.paper.report.QUICK_POINTS", 60)
    monkeypatch.setattr("slam.bench.paper.report.QUICK_TRIALS", 3)
    monkeypatch.setattr("slam.bench.paper.report.QUICK_DURATION", 2.0)
    report = reproduce(tmp_path / "paper", quick=True, console=Terminal(quiet=True))
    text = report.path.read_text()
    assert {path.name for path in (tmp_path / "paper").iterdir()} == {
        "report.md", "fig_3.png", "fig_7.png", "fig_8.png", "fig_10.png", "fig_21.png",
    }  # fmt: skip
    assert "Only 60 points were used" in text
    assert "28.36" in text
    assert all(f"]({name}.png)" in text for name in ("fig_3", "fig_7", "fig_8", "fig_10", "fig_21"))


def test_without_scikit_image_the_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "skimage.transform", None)
    with pytest.raises(InputError, match=r"skimage is not installed; run: pip install 'hopslam\[bench\]'"):
        reproduce(tmp_path / "paper", quick=True, console=Terminal(quiet=True))
    assert not (tmp_path / "paper").exists()
