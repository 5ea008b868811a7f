"""CARMEN logs: messages, missing echoes, garbled lines, and recorded logs."""

import gzip
from collections.abc import Sequence
from math import cos, pi, radians, sin
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from slam.errors import LogError
from slam.files.logs import Log, read_log
from slam.lidars import whole_steps
from slam.pose import Pose2D

DATA = Path(__file__).parents[1] / "../shared/data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded logs in {DATA}")
one_directory = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
ORIGIN = Pose2D()


def words(*values: float) -> str:
    return " ".join(map(str, values))


def pose(at: Pose2D) -> str:
    return words(at.x, at.y, at.theta)


def flaser(ranges: Sequence[float], stamp: float, robot: Pose2D = ORIGIN, laser: Pose2D | None = None) -> str:
    return f"FLASER {len(ranges)} {words(*ranges)} {pose(laser or robot)} {pose(robot)} {stamp:.6f} host {stamp:.6f}"


def robotlaser1(ranges: Sequence[float], stamp: float, laser: Pose2D = ORIGIN, robot: Pose2D = ORIGIN) -> str:
    fan = f"0 {-pi / 4} {pi / 2} {pi / 8} 20 0.01 2"
    echoes = f"{len(ranges)} {words(*ranges)} 3 17 18 19"
    return f"ROBOTLASER1 {fan} {echoes} {pose(laser)} {pose(robot)} 0.1 0.2 0.3 0.4 0.5 {stamp:.6f} host {stamp:.6f}"


def read(directory: Path, *lines: str) -> Log:
    path = directory / "run.dat"
    path.write_text("\n".join(lines) + "\n")
    return read_log(path)


def test_an_old_message_is_read(tmp_path: Path) -> None:
    start, end = Pose2D(4.0, 2.0, pi / 2), Pose2D(4.0, 3.0, pi)
    log = read(tmp_path, flaser([1.5, 2.5, 0.0], 7.25, start), flaser([1.0, 2.0, 90.0], 7.5, end))
    assert len(log) == 2
    assert log.report == "2 scans"
    np.testing.assert_array_equal(log.ranges, [[1.5, 2.5, np.inf], [1.0, 2.0, np.inf]])
    np.testing.assert_array_equal(log.stamps, [7.25, 7.5])
    np.testing.assert_allclose(log.T_odom_base, [[0.0, 0.0, 0.0], [1.0, 0.0, pi / 2]], atol=1e-12)
    assert log.T_base_laser == ORIGIN
    assert log.lidar.scan_time == 0.25


@pytest.mark.parametrize(("beams", "increment", "last"), [(180, 1, 89), (181, 1, 90), (360, 0.5, 89.5), (361, 0.5, 90)])
def test_the_fan_of_an_old_message_is_known(tmp_path: Path, beams: int, increment: float, last: float) -> None:
    scan = read(tmp_path, flaser([1.0 + 0.01 * j for j in range(beams)], 1.0)).scan(0)
    assert scan.angle_min == pytest.approx(-pi / 2)
    assert scan.angle_increment == pytest.approx(radians(increment))
    assert scan.lidar.angle_max == pytest.approx(radians(last))
    assert len(scan.points()) == beams


def test_a_new_message_is_read(tmp_path: Path) -> None:
    robot = Pose2D(1.0, 2.0, 0.7)
    log = read(tmp_path, robotlaser1([3.0, 20.0, 0.0, 19.99, 81.83], 5.0, robot @ Pose2D(0.25, -0.1, 3.1), robot))
    scan = log.scan(0)
    assert (scan.angle_min, scan.angle_increment, scan.range_max) == (-pi / 4, pi / 8, 20.0)
    np.testing.assert_array_equal(scan.ranges, [3.0, np.inf, np.inf, 19.99, np.inf])
    assert log.T_base_laser.distance(Pose2D(0.25, -0.1)) < 1e-12
    assert log.T_base_laser.theta == pytest.approx(3.1)
    assert log.odometry(0).T_odom_base == ORIGIN


@pytest.mark.parametrize(
    ("ranges", "range_max"),
    [
        ([7.0, 50.0, 50.0, 49.0], 50.0),  # the farthest reading, which occurs several times
        ([7.0, 8.0, 9.0, 49.0], 80.0),
        ([7.0, 81.83, 81.91, 81.91], 80.0),
        ([7.0, 8.183, 8.191, 8.191], 8.183),  # a SICK's error codes in millimetres
        ([7.0, 0.0, 0.0, 3.0], 80.0),
        ([7.0, float("inf"), float("inf"), 3.0], 80.0),
    ],
)
def test_the_reach_of_an_old_log_is_known(tmp_path: Path, ranges: list[float], range_max: float) -> None:
    scan = read(tmp_path, flaser(ranges, 1.0)).scan(0)
    assert scan.range_max == range_max
    np.testing.assert_array_equal(np.isfinite(scan.ranges), [0 < r < range_max for r in ranges])


def test_the_mount_is_a_median(tmp_path: Path) -> None:
    robots = [Pose2D(i, i / 2, 1.3 * i) for i in range(9)]
    lasers = [robot @ Pose2D(0.25, 0.0, pi) for robot in robots]
    lasers[4] = Pose2D(1e6, 0.0, 0.0)
    log = read(tmp_path, *(robotlaser1([1.0], float(i), lasers[i], robots[i]) for i in range(9)))
    assert log.T_base_laser.distance(Pose2D(0.25)) < 1e-9
    assert (cos(log.T_base_laser.theta), sin(log.T_base_laser.theta)) == pytest.approx((-1.0, 0.0))


def test_corrected_laser_poses_do_not_define_the_mount(tmp_path: Path) -> None:
    log = read(tmp_path, *(flaser([1.0, 2.0], float(i), Pose2D(i), Pose2D(i, 0.1 * i)) for i in range(5)))
    assert log.T_base_laser == ORIGIN
    assert "not fixed to the robot" in log.report


def test_other_messages_are_counted_and_comments_are_not(tmp_path: Path) -> None:
    others = [
        "# CARMEN Logfile",
        "",
        "PARAM robot_width 0.5 1 host 1",
        "ODOM 1 2 3 0 0 0 1 host 1",
        "ODOM",
        "NEWTYPE 1",
    ]
    log = read(tmp_path, *others, flaser([1.0, 2.0], 1.0), "RLASER 1 2")
    assert dict(log.ignored) == {"PARAM": 1, "ODOM": 2, "other": 1, "RLASER": 1}
    assert log.report == "1 scan"


GOOD = [robotlaser1([1.0, 2.0, 3.0], float(i)) for i in range(1, 6)]


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        (GOOD[2].rpartition(" host")[0], "truncated"),
        ("FLASER", "truncated"),
        ("FLASER 99999999999999999999 1 2", "truncated"),
        (GOOD[2] + " " + GOOD[3], "too long"),
        (GOOD[2].replace("2.0", "2.O"), "not a number"),
        ("FLASER 3.5 1", "not a number"),
        (GOOD[2].replace("2.0", "nan"), "impossible value"),
        (GOOD[2].replace("2.0", "-2.0"), "impossible value"),
        (GOOD[2].replace("3.000000 host", "inf host"), "impossible value"),
        (GOOD[2].replace(f"{pi / 8}", "0"), "impossible value"),
        (flaser([], 3.0), "impossible value"),
        ("FLASER -1 1", "impossible value"),
        (GOOD[1], "repeated"),
        (GOOD[0], "repeated"),
        ("\0\1\2", "not a message"),
    ],
)
def test_a_bad_line_loses_no_other_line(tmp_path: Path, line: str, kind: str) -> None:
    log = read(tmp_path, *GOOD[:2], line, *GOOD[2:])
    np.testing.assert_array_equal(log.stamps, [1, 2, 3, 4, 5])
    assert dict(log.skipped) == {kind: 1}
    assert log.report.startswith(f"5 scans, 1 line skipped (1 {kind}")
    assert log.report.endswith(", line 3)")


def test_the_report_counts_by_kind(tmp_path: Path) -> None:
    log = read(tmp_path, *GOOD, "FLASER 3", GOOD[0], "FLASER 3 1")
    assert log.report == "5 scans, 3 lines skipped (2 truncated, lines 6 to 8; 1 repeated, line 7)"


@pytest.mark.parametrize(
    ("line", "report"),
    [
        (GOOD[2].replace("2.0", "-2.0"), "impossible value: range 2 of 3 -2, line 3"),
        (GOOD[2].replace("3.000000 host", "inf host"), "impossible value: stamp inf, line 3"),
        (GOOD[2].replace(f"{pi / 8}", "0"), "impossible value: resolution 0, line 3"),
        (flaser([], 3.0), "impossible value: number of beams 0, line 3"),
    ],
)
def test_an_impossible_value_is_named(tmp_path: Path, line: str, report: str) -> None:
    assert report in read(tmp_path, *GOOD[:2], line, *GOOD[2:]).report


def test_a_garbled_stamp_costs_no_scan(tmp_path: Path) -> None:
    log = read(tmp_path, *GOOD[:2], robotlaser1([1.0, 2.0, 3.0], 1e9), *GOOD[2:])
    np.testing.assert_array_equal(log.stamps, [1, 2, 2.5, 3, 4, 5])
    assert log.report == "6 scans; stamps that do not increase, set between their neighbours (1: line 3)"


def test_the_logger_time_is_optional(tmp_path: Path) -> None:
    assert len(read(tmp_path, GOOD[0].rpartition(" ")[0])) == 1


def test_gzip_is_known_by_content(tmp_path: Path) -> None:
    path = tmp_path / "run.txt"
    path.write_bytes(gzip.compress("\r\n".join(GOOD).encode()))
    assert read_log(str(path)).report == "5 scans"


@pytest.mark.parametrize("damage", ["cut", "corrupt"])
def test_a_damaged_gzip_is_read_up_to_the_damage(tmp_path: Path, damage: str) -> None:
    ranges = np.random.default_rng(0).uniform(1, 9, (500, 100)).round(3)
    whole = gzip.compress("\n".join(flaser(row.tolist(), float(i)) for i, row in enumerate(ranges)).encode())
    half = len(whole) // 2
    path = tmp_path / "run.log"
    path.write_bytes(whole[:half] if damage == "cut" else whole[:half] + b"\xff" * 99 + whole[half + 99 :])
    log = read_log(path)
    assert 200 < len(log) < 300
    np.testing.assert_array_equal(log.stamps, np.arange(len(log)))
    assert log.report.endswith("; the gzip data are damaged or end early, and what comes after that is lost")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "nothing"),
        (b"\0" * 3_000_000, r"begins with b'\\x00"),
        (b"#ROSBAG V9.2\n\r\0\0", "begins with b'#ROSBAG V9.2'"),
        (gzip.compress(b"hello world" * 1000, mtime=0)[:-30], "damaged or end early"),
        (b"PARAM a 1\nODOM 1\nODOM 1\nFLASER 3\n", "no scan in this log: 2 ODOM, 1 PARAM, 1 line skipped"),
    ],
)
def test_a_file_that_is_not_a_log_is_an_error_of_one_line(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "thing"
    path.write_bytes(content)
    with pytest.raises(LogError, match=f"^{path}: .*{message}.*; need .*CARMEN|FLASER") as caught:
        read_log(path)
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_opened_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(LogError, match=r"absent: no such file"):
        read_log(tmp_path / "absent")
    with pytest.raises(LogError, match=r"not a file"):
        read_log(tmp_path)
    (tmp_path / "locked").touch()
    monkeypatch.setattr(Path, "open", lambda *_: (_ for _ in ()).throw(PermissionError(13, "Permission denied")))
    with pytest.raises(LogError, match=r"locked: cannot be read: Permission denied"):
        read_log(tmp_path / "locked")


def test_a_very_long_line_is_one_bad_line(tmp_path: Path) -> None:
    log = read(tmp_path, GOOD[0], "FLASER 9 " + "1 " * 2_000_000, GOOD[1])
    assert log.report == "2 scans, 1 line skipped (1 too long, line 2)"


@one_directory
@given(st.binary(max_size=300), st.booleans())
def test_random_bytes_never_break_the_reader(tmp_path: Path, junk: bytes, named: bool) -> None:
    path = tmp_path / "junk"
    path.write_bytes(b"FLASER 1 " * named + junk)
    with pytest.raises(LogError):
        read_log(path)


@one_directory
@given(st.data())
def test_damage_to_one_line_never_loses_another(tmp_path: Path, data: st.DataObject) -> None:
    line = data.draw(st.integers(0, len(GOOD) - 1))
    text = GOOD[line].encode()
    end = text.index(b" 0.1 ")  # the time stamps stay: they could become those of another line
    first = data.draw(st.integers(0, end))
    last = data.draw(st.integers(first, end))
    damaged = text[:first] + data.draw(st.binary(max_size=20)) + text[last:]
    path = tmp_path / "damaged"
    header = b"# CARMEN Logfile"  # the first bytes of a file say what kind it is, and are not damaged here
    path.write_bytes(
        b"\n".join([header, *(g.encode() for g in GOOD[:line]), damaged, *(g.encode() for g in GOOD[line + 1 :])])
    )
    assert set(read_log(path).stamps.tolist()) | {line + 1.0} == {1.0, 2.0, 3.0, 4.0, 5.0}


@needs_data
@pytest.mark.parametrize(
    ("name", "scans", "beams", "length", "mount", "range_max", "no_echo"),
    [
        ("fr079", 4791, 360, pytest.approx(423, rel=0.08), 0.0, 50.0, 0.0209),
        ("aces", 440, 180, pytest.approx(323, rel=0.02), 0.0, 50.0, 0.0078),
        ("fr101", 292, 360, pytest.approx(211, rel=0.02), 0.0, 50.0, 0.1196),
        ("belgioioso", 395, 361, pytest.approx(219, rel=0.02), 0.0, 50.0, 0.0051),
        ("duke_loop5", 551, 181, pytest.approx(56, rel=0.02), 0.0, 8.18, 0.0674),
        ("wean1", 713, 180, pytest.approx(41, rel=0.02), 0.25, 81.8, 0.0054),
        ("wean3", 1241, 180, pytest.approx(43, rel=0.02), 0.25, 81.8, 0.0164),
        ("corridor_synthetic", 2240, 682, pytest.approx(65 * 1.02, rel=0.01), 0.0, 4.0, 0.2205),
    ],
)
def test_recorded_logs_are_read_completely(
    name: str, scans: int, beams: int, length: float, mount: float, range_max: float, no_echo: float
) -> None:
    log = read_log(DATA / f"{name}.log.gz")
    assert log.report == f"{scans} scans"
    assert log.ranges.shape == (scans, beams)
    assert np.hypot(*np.diff(log.T_odom_base[:, :2], axis=0).T).sum() == length
    assert log.T_base_laser.distance(Pose2D(mount)) < 1e-6
    assert log.lidar.range_max == range_max
    assert np.isposinf(log.ranges).mean() == pytest.approx(no_echo, abs=1e-4)
    assert log.scan(scans - 1).echoes.sum() == np.isfinite(log.ranges[-1]).sum()
    assert (np.diff(log.stamps) > 0).all()


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ((-1.5707963, 0.017453293), (-np.pi / 2, np.pi / 180)),
        ((-1.5707963, 0.008726646), (-np.pi / 2, np.pi / 360)),
        ((-1.570796, 0.017453), None),
        ((-1.5, 1e-300), None),
        ((0.0, -1.0), None),
    ],
)
def test_bearings_are_whole_steps_if_seven_digits_agree(
    written: tuple[float, float], meant: tuple[float, float] | None
) -> None:
    assert whole_steps(*written) == (None if meant is None else pytest.approx(meant, rel=1e-15))
