"""The text logs of a URG-04LX with wheel encoders: units, error codes, dead reckoning, garbled lines, mines1."""

import gzip
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from slam.errors import LogError
from slam.files.logs import Log, read_log
from slam.pose import Pose2D

DATA = Path(__file__).parents[1] / "../shared/data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded logs in {DATA}")
CIRCUMFERENCE = 2 * pi * 0.077


def scan(microseconds: int, left: int = 0, right: int = 0, ranges: dict[int, int] | None = None) -> str:
    readings = [(ranges or {}).get(beam, 1000) for beam in range(682)]
    return " ".join(map(str, [microseconds, -1, left, right, *([0] * 20), *readings, 0]))


def read(directory: Path, *lines: str) -> Log:
    path = directory / "run.log"
    path.write_text("\n".join(lines))
    return read_log(path)


def test_units_and_error_codes_are_read(tmp_path: Path) -> None:
    readings = {0: 0, 1: 20, 2: 5600, 3: 5601, 4: 19, 5: 1, 681: 1234}
    log = read(tmp_path, scan(212_387_282, 29_221, 25_178, readings), scan(212_487_282, 29_221, 25_178))
    first = log.scan(0)
    assert first.stamp == 212.387282
    np.testing.assert_array_equal(first.ranges[:7], [np.inf, 0.02, 5.6, np.inf, np.nan, np.nan, 1.0])
    assert first.ranges[681] == 1.234
    assert first.lidar.beams == 682
    assert first.angle_min == pytest.approx((44 - 384) * 2 * pi / 1024)
    assert first.lidar.angle_max == pytest.approx((725 - 384) * 2 * pi / 1024)
    assert first.time_increment == pytest.approx(60 / 600 / 1024)
    assert first.scan_time == pytest.approx(0.1)
    assert log.T_base_laser == Pose2D(0.145, 0.0, 0.0)


def test_a_turn_of_both_wheels_is_their_circumference(tmp_path: Path) -> None:
    log = read(tmp_path, scan(0, 500, -500), scan(100_000, 2500, 1500), scan(200_000, 500, -500))
    np.testing.assert_allclose(
        log.T_odom_base, [[0.0, 0.0, 0.0], [CIRCUMFERENCE, 0.0, 0.0], [0.0, 0.0, 0.0]], atol=1e-12
    )
    assert log.twist(0).linear == pytest.approx(CIRCUMFERENCE / 0.1)


def test_a_faster_right_wheel_turns_left(tmp_path: Path) -> None:
    log = read(tmp_path, scan(0), scan(100_000, -100, 100))
    np.testing.assert_allclose(log.T_odom_base[1], [0, 0, 2 * 0.1 * CIRCUMFERENCE / 2 / 0.33], atol=1e-12)


def test_the_last_column_may_be_missing(tmp_path: Path) -> None:
    assert len(read(tmp_path, scan(1).removesuffix(" 0"))) == 1


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        (scan(3)[:-40], "truncated"),
        ("1", "truncated"),
        (scan(3) + " " + scan(4), "too long"),
        (scan(3, ranges={9: -5}), "impossible value"),
        (scan(3).replace(" 1000 ", " nan ", 1), "impossible value"),
        (scan(3).replace("3 -1 0", "3 -1 inf"), "impossible value"),
        (scan(3).replace(" 1000 ", " 10OO ", 1), "not a number"),
        (scan(2), "repeated"),
        (scan(1), "repeated"),
    ],
)
def test_a_bad_line_loses_no_other_line(tmp_path: Path, line: str, kind: str) -> None:
    log = read(tmp_path, "# comment", scan(1), scan(2), line, scan(3), scan(4), scan(5))
    np.testing.assert_array_equal(log.stamps, [1e-6, 2e-6, 3e-6, 4e-6, 5e-6])
    assert log.report.startswith(f"5 scans, 1 line skipped (1 {kind}")
    assert log.report.endswith(", line 4)")


def test_numbers_that_are_not_scans_are_an_error(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="not a log that hopslam can read: a file that begins with b'1 2 3'"):
        read(tmp_path, "1 2 3", "4 5 6")


def test_a_truncated_gzip_is_read_up_to_its_end(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(20, 5600, (200, 682))
    lines = [scan(i, ranges=dict(enumerate(row.tolist()))) for i, row in enumerate(noise)]
    whole = gzip.compress("\n".join(lines).encode())
    (tmp_path / "cut").write_bytes(whole[: len(whole) // 2])
    log = read_log(tmp_path / "cut")
    assert 80 < len(log) < 120
    np.testing.assert_array_equal(log.ranges, noise[: len(log)] / 1000)
    assert "end early" in log.report


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.binary(max_size=200), st.integers(0, 4000), st.integers(0, 4000))
def test_damage_to_one_line_never_loses_another(tmp_path: Path, junk: bytes, first: int, removed: int) -> None:
    bad = scan(3).encode()
    first = max(first, 10)  # the time stamp stays: it could become that of another line
    path = tmp_path / "damaged"
    path.write_bytes(b"\n".join([scan(1).encode(), bad[:first] + junk + bad[first + removed :], scan(5).encode()]))
    assert {1e-6, 5e-6} <= set(read_log(path).stamps.tolist())


@needs_data
def test_the_mines1_log_is_read() -> None:
    log = read_log(DATA / "mines1.dat.gz")
    assert log.report == "756 scans"
    assert log.ranges.shape == (756, 682)
    assert log.T_base_laser == Pose2D(0.145)
    assert np.isfinite(log.ranges).mean() == pytest.approx(0.447, abs=0.001)
    assert np.hypot(*np.diff(log.T_odom_base[:, :2], axis=0).T).sum() == pytest.approx(46, rel=0.01)
    assert log.stamps[-1] - log.stamps[0] == pytest.approx(75, abs=0.5)
    assert log.lidar.scan_time == pytest.approx(0.1, rel=0.03)
