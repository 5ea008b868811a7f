"""ROS 1 bags of laser scans: written here byte by byte, and urgdemo.bag."""

import bz2
import re
import shlex
import struct
from contextlib import suppress
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from slam.errors import LogError
from slam.files.logs import BagTopics, read_log
from slam.files.logs.rosbag1 import MAGIC
from slam.pose import Pose2D

BAG = Path(__file__).parents[1] / "../shared/data/urgdemo.bag"
SCAN = b"sensor_msgs/LaserScan"


def record(data: bytes, **fields: bytes) -> bytes:
    header = b"".join(
        struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value for name, value in fields.items()
    )
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def connection(number: int, kind: bytes = SCAN, topic: bytes = b"/scan") -> bytes:
    kind_field = b"type=" + kind
    return record(
        struct.pack("<I", len(kind_field)) + kind_field, op=b"\x07", conn=struct.pack("<I", number), topic=topic
    )


def message(stamp: float, ranges: list[float], number: int = 0, step: float = 0.01) -> bytes:
    seconds, nanoseconds = int(stamp), round(1e9 * (stamp % 1.0))
    data = struct.pack("<4I5s", 1, seconds, nanoseconds, 5, b"laser")
    data += struct.pack("<7fI", -1.0, 1.0, step, 0.001, 0.1, 0.02, 5.6, len(ranges))
    data += struct.pack(f"<{len(ranges)}fI", *ranges, 0)
    return record(data, op=b"\x02", conn=struct.pack("<I", number), time=b"\0" * 8)


def bag(*records: bytes, compression: bytes = b"none", index_length: int = 24) -> bytes:
    """A bag of one chunk; its index has 2 entries, and states a length of ``index_length`` bytes."""
    body = b"".join(records)
    data = {b"bz2": bz2.compress, b"lz4": lz4.frame.compress}.get(compression, bytes)(body)
    chunk = record(data, op=b"\x05", compression=compression, size=struct.pack("<I", len(body)))
    count = struct.pack("<I", 2)
    index = record(bytes(24), op=b"\x04", ver=struct.pack("<I", 1), conn=bytes(4), count=count)
    index = index[:-28] + struct.pack("<I", index_length) + bytes(24)
    return MAGIC + record(b" " * 100, op=b"\x03") + chunk + index + connection(0)


SCANS = (message(10.5, [1.0, 2.0, 6.0]), message(10.6, [0.01, np.inf, np.nan]))


@pytest.mark.parametrize("compression", [b"none", b"bz2", b"lz4"])
@pytest.mark.parametrize("index_length", [24, 40])
def test_scans_are_read_in_si_units(tmp_path: Path, compression: bytes, index_length: int) -> None:
    """The wrong length of the index is what recorders of 2010 wrote."""
    path = tmp_path / "run.bag"
    path.write_bytes(bag(connection(0), *SCANS, compression=compression, index_length=index_length))
    log = read_log(path)
    assert log.report == "2 scans; no odometry in it"
    assert not log.has_odometry
    np.testing.assert_allclose(log.stamps, [10.5, 10.6])
    np.testing.assert_array_equal(log.ranges, [[1.0, 2.0, np.inf], [-np.inf, np.inf, np.nan]])
    assert log.lidar.beams == 3
    assert log.lidar.angle_min == -1.0
    assert log.lidar.angle_increment == pytest.approx(0.01)
    assert log.lidar.range_max == pytest.approx(5.6)
    assert log.time_increment == pytest.approx(0.001)
    assert log.pose(1) == Pose2D()


def test_one_of_two_scan_topics_is_chosen(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    connections = (connection(0), connection(1, b"std_msgs/String", b"/chat"), connection(2, topic=b"/rear"))
    path.write_bytes(bag(*connections, SCANS[0], message(10.55, [1.0], 1), message(10.56, [9.0], 2), SCANS[1]))
    assert "2 topics of sensor_msgs/msg/LaserScan: /scan (2), /rear (1); /scan is read, --scan-topic NAME chooses" in (
        read_log(path).report
    )
    with pytest.raises(LogError, match=r"--scan-topic /front: not among .*: /rear, /scan"):
        read_log(path, BagTopics(scan="/front"))
    log = read_log(path, BagTopics(scan="scan"))
    assert len(log) == 2
    assert log.ignored == {"std_msgs/msg/String": 1}


def test_bad_messages_lose_no_other_message(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    cut = record(b"\0" * 30, op=b"\x02", conn=bytes(4), time=bytes(8))
    path.write_bytes(bag(connection(0), SCANS[0], cut, message(10.55, [1, 1, 1], step=0.0), SCANS[1]))
    report = read_log(path).report
    assert (
        "2 scans, 2 messages skipped (1 truncated, message 2; 1 impossible value: angle_increment 0, message 3)"
        in report
    )


def test_a_truncated_bag_is_read_up_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    path.write_bytes(bag(connection(0), *SCANS)[:-60])
    log = read_log(path)
    assert len(log) == 2
    assert "damaged or ends early" in log.report


def test_an_unreadable_bag_names_the_command_to_run(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    path.write_bytes(bag(connection(0), *SCANS, compression=b"xz"))
    with pytest.raises(LogError, match=rf"packed with xz; run: rosbag decompress {re.escape(shlex.quote(str(path)))}"):
        read_log(path)


def test_a_bag_without_scans_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    path.write_bytes(bag(connection(1, b"std_msgs/String", b"/chat"), message(10.55, [1.0], 1)))
    with pytest.raises(LogError, match="no scan in this log: 1 std_msgs/msg/String"):
        read_log(path)


def test_an_empty_bag_is_an_error_of_one_line(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    path.write_bytes(MAGIC + b"\r\0\0")
    with pytest.raises(
        LogError, match=r"no scan in this log: no message of a robot; the bag is damaged or ends early.*; need sensor_"
    ):
        read_log(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.binary(max_size=50), st.integers(13, 900), st.integers(0, 60))
def test_damage_is_at_most_a_log_error(tmp_path: Path, junk: bytes, first: int, removed: int) -> None:
    whole = bag(connection(0), *SCANS)
    path = tmp_path / "damaged.bag"
    path.write_bytes(whole[:first] + junk + whole[first + removed :])
    with suppress(LogError):
        assert len(read_log(path)) <= 2


@pytest.mark.skipif(not BAG.is_file(), reason=f"no {BAG}")
def test_the_urgdemo_bag_is_read() -> None:
    log = read_log(BAG)
    assert log.report == "360 scans; no odometry in it"
    assert log.ranges.shape == (360, 681)
    assert log.stamps[-1] - log.stamps[0] == pytest.approx(35.8, abs=0.1)
    assert np.isfinite(log.ranges).mean() == pytest.approx(0.946, abs=0.001)
