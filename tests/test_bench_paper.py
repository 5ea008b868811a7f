"""The paper's figures measured again: its formulas by hand, and what does not depend on the clock."""

import sys
from pathlib import Path

import numpy as np
import pytest

from slam.bench.paper import fig_7, fig_8, fig_10, table_2
from slam.bench.paper.report import reproduce
from slam.bench.paper.speed_up import hops, predicted_speed_up
from slam.console.terminal import Terminal
from slam.errors import InputError


def test_hops_by_hand() -> None:
    """Eq. (14)."""
    assert hops(10, 2) == (3, 3)
    assert hops(12, 2) == (3, 5)
    assert hops(12, 0) == (11, 11)


def test_the_predicted_speed_up_by_hand() -> None:
    """Eq. (13) with t(j) = j: 45 / (1 + 4 + 7), then 66 / (1 + 4 + 7 + 4 + 5)."""
    assert predicted_speed_up(10, 2) == 45 / 12
    assert predicted_speed_up(12, 2) == 66 / 21
    assert predicted_speed_up(12, 2, lambda points: 1.0) == 11 / 5
    assert predicted_speed_up(2280, 0) == 1.0


def test_the_wall_is_one_segment_with_as_many_tests_as_the_prediction_counts() -> None:
    for psi in table_2.PSI:
        tests = table_2.count_tests(table_2.wall(table_2.POINTS // 10), table_2.SIGMA_TH, psi)
        assert tests == pytest.approx(hops(table_2.POINTS // 10, psi)[1], abs=psi + 1)


def test_hopping_changes_no_segment_and_too_much_of_it_costs_tests() -> None:
    rows = {row.psi: row for row in fig_7.measure(trials=30)}
    assert all(row.different == 0 for row in rows.values())
    assert rows[0].tests > 2 * rows[5].tests
    assert rows[40].tests > 2 * rows[5].tests


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


def test_the_report_and_its_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("skimage")
    monkeypatch.setattr("slam.bench.paper.report.QUICK_POINTS", 60)
    monkeypatch.setattr("slam.bench.paper.report.QUICK_TRIALS", 3)
    report = reproduce(tmp_path / "paper", quick=True, console=Terminal(quiet=True))
    text = report.path.read_text()
    assert {path.name for path in (tmp_path / "paper").iterdir()} == {
        "report.md", "fig_7.png", "fig_8.png", "fig_10.png",
    }  # fmt: skip
    assert "Only 60 points were used" in text
    assert "28.36" in text
    assert all(f"]({name}.png)" in text for name in ("fig_7", "fig_8", "fig_10"))


def test_without_scikit_image_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "skimage.transform", None)
    with pytest.raises(InputError, match=r"skimage is not installed; run: pip install 'hopslam\[bench\]'"):
        reproduce(tmp_path / "paper", quick=True, console=Terminal(quiet=True))
    assert not (tmp_path / "paper").exists()
