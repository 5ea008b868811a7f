"""Bags written by rosbags, and MCAP files by the project and by mcap, read as logs."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from slam.errors import LogError
from slam.files.logs import BagTopics, read_log
from slam.files.logs.bag_poses import PoseSeries
from slam.files.ros.encoder import Encoder, nanoseconds
from slam.files.ros.mcap_files import McapWriter
from slam.files.ros.messages import LASER_SCAN, ODOMETRY, TRANSFORMS, ros1_types, ros2_types
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.scan import LaserScan

ENCODER = Encoder()
STILL = Twist2D()
MOUNT = Pose2D(0.16, 0.0, 0.25)
FOOT = Pose2D(0.0, 0.0, 0.5)
CONTAINERS = ("rosbag1", "sqlite3", "mcap folder", "mcap")


@dataclass
class Talk:
    """Messages in the order of a bag: topic, type, time, CDR."""

    messages: list[tuple[str, str, float, bytes]] = field(default_factory=list)

    def scan(self, stamp: float, topic: str = "/scan") -> None:
        ranges = np.random.default_rng(int(100 * stamp)).uniform(1.0, 3.0, 50).astype(np.float32)
        scan = LaserScan(stamp, -0.5, 0.0625, 0.125, 4.0, ranges.astype(float), 0.0009765625)
        self.messages.append((topic, LASER_SCAN, stamp, ENCODER.scan(scan)))

    def odometry(self, stamp: float, topic: str = "/odom", twist: Twist2D = STILL) -> None:
        self.messages.append((topic, ODOMETRY, stamp, ENCODER.odometry(Odometry(stamp, odometry_at(stamp), twist))))

    def transforms(self, stamp: float, *links: tuple[str, str, Pose2D], topic: str = "/tf") -> None:
        self.messages.append((topic, TRANSFORMS, stamp, ENCODER.transforms(stamp, *links)))

    def write(self, folder: Path, container: str) -> Path:
        path = folder / ("run.bag" if container == "rosbag1" else "run.mcap" if container == "mcap" else "run")
        if container == "mcap":
            self._write_mcap(path)
        elif container == "rosbag1":
            self._write_rosbag1(path)
        else:
            self._write_rosbag2(path, StoragePlugin.SQLITE3 if container == "sqlite3" else StoragePlugin.MCAP)
        return path

    def _write_mcap(self, path: Path) -> None:
        writer = McapWriter(path, ENCODER, 2000)
        for topic, _, stamp, data in self.messages:
            writer.write(topic, nanoseconds(stamp), data)
        writer.close()

    def _write_rosbag1(self, path: Path) -> None:
        with Writer1(path) as writer:
            topics = {(topic, kind) for topic, kind, *_ in self.messages}
            ids = {t: writer.add_connection(t, kind, typestore=ros1_types()) for t, kind in sorted(topics)}
            for topic, kind, stamp, data in self.messages:
                message = ros2_types().deserialize_cdr(data, kind)
                writer.write(ids[topic], nanoseconds(stamp), ros1_types().serialize_ros1(as_ros1(message), kind))

    def _write_rosbag2(self, path: Path, storage: StoragePlugin) -> None:
        with Writer2(path, version=9, storage_plugin=storage) as writer:
            topics = {(topic, kind) for topic, kind, *_ in self.messages}
            ids = {t: writer.add_connection(t, kind, typestore=ros2_types()) for t, kind in sorted(topics)}
            for topic, _, stamp, data in self.messages:
                writer.write(ids[topic], nanoseconds(stamp), data)


def as_ros1(message: object) -> object:
    """Convert a message to ROS 1, whose headers have a sequence number too."""
    for part in (message, *getattr(message, "transforms", [])):
        if hasattr(part, "header"):
            header = ros1_types().types["std_msgs/msg/Header"]
            object.__setattr__(part, "header", header(0, part.header.stamp, part.header.frame_id))
    return message


def odometry_at(stamp: float) -> Pose2D:
    return Pose2D(1.0 + 0.5 * stamp, 0.25 * stamp, 3.0 + 0.5 * stamp)


@pytest.fixture
def talk() -> Talk:
    """Five scans at 10 Hz amid odometry at 40 Hz, the lidar on a mast on the base."""
    talk = Talk()
    talk.transforms(1.0, ("base_link", "mast", FOOT), ("mast", "laser", FOOT.inverse() @ MOUNT), topic="/tf_static")
    for k in range(17):
        talk.odometry(1.0 + 0.025 * k)
        if k % 4 == 0:
            talk.scan(1.0 + 0.025 * k + 0.001 * (0 < k < 16))
    return talk


@pytest.mark.parametrize("container", CONTAINERS)
def test_scans_odometry_and_mount_are_read(tmp_path: Path, talk: Talk, container: str) -> None:
    log = read_log(talk.write(tmp_path, container))
    assert log.report == "5 scans"
    assert log.lidar.beams == 50
    assert log.time_increment == 0.0009765625
    assert (log.T_base_laser.x, log.T_base_laser.theta) == pytest.approx((MOUNT.x, MOUNT.theta))
    for k, stamp in enumerate((1.0, 1.101, 1.201, 1.301, 1.4)):
        true = odometry_at(1.0).between(odometry_at(stamp))
        assert log.stamps[k] == pytest.approx(stamp, abs=1e-9)
        assert log.T_odom_base[k] == pytest.approx([true.x, true.y, true.theta], abs=1e-9)
    assert log.twists is None  # all of them are zero: not measured
    assert log.odometry(2).twist.angular == pytest.approx(0.5)


@pytest.mark.parametrize("container", CONTAINERS)
def test_transforms_replace_odometry_messages(tmp_path: Path, container: str) -> None:
    talk = Talk()
    for stamp in (0.0, 0.1, 0.2):
        talk.transforms(stamp, ("map", "odom", Pose2D(5.0)), ("odom", "base_link", odometry_at(stamp)))
        talk.scan(stamp)
    log = read_log(talk.write(tmp_path, container))
    assert log.report == "3 scans; no transform from base_link to laser, so the laser is taken to sit on its centre"
    assert log.odometry(1).twist.angular == pytest.approx(0.5)
    assert log.start == Pose2D(5.0) @ odometry_at(0.0)


def test_the_twist_is_the_measured_one(tmp_path: Path, talk: Talk) -> None:
    talk.messages = [message for message in talk.messages if message[1] != ODOMETRY]
    for stamp, speed in ((1.0, 0.25), (1.2, 0.75), (1.4, 0.75)):
        talk.odometry(stamp, twist=Twist2D(speed, -speed))
    log = read_log(talk.write(tmp_path, "mcap"))
    assert log.odometry(0).twist == Twist2D(0.25, -0.25)
    assert log.odometry(1).twist.linear == pytest.approx(0.25 + 0.5 * 0.101 / 0.2)


def test_a_topic_is_chosen_by_name(tmp_path: Path, talk: Talk) -> None:
    talk.odometry(1.0, topic="/wheels/odom")
    path = talk.write(tmp_path, "sqlite3")
    report = read_log(path).report
    assert "/wheels/odom (1); /odom is read, --odom-topic NAME chooses another" in report
    assert "/wheels/odom" not in read_log(path, BagTopics(odometry="/odom")).report
    with pytest.raises(LogError, match="--odom-topic /none: not among its topics of nav_msgs/msg/Odometry: /odom, /wh"):
        read_log(path, BagTopics(odometry="/none"))


def test_topics_are_options_of_bags_only(small_log: Path) -> None:
    with pytest.raises(LogError, match="leave out --scan-topic"):
        read_log(small_log, BagTopics(scan="/scan"))


def test_a_tilted_lidar_is_refused(tmp_path: Path, talk: Talk) -> None:
    turned = ros2_types().types["geometry_msgs/msg/Quaternion"](0.5**0.5, 0.0, 0.0, 0.5**0.5)
    over = ros2_types().deserialize_cdr(talk.messages[0][3], TRANSFORMS)
    object.__setattr__(over.transforms[1].transform, "rotation", turned)
    talk.messages[0] = (*talk.messages[0][:3], bytes(ros2_types().serialize_cdr(over, TRANSFORMS)))
    with pytest.raises(LogError, match=r"from base_link to laser tilt the lidar by 90 degrees"):
        read_log(talk.write(tmp_path, "mcap"))


def test_odometry_of_another_time_is_noted(tmp_path: Path) -> None:
    talk = Talk()
    talk.odometry(500.0)
    talk.scan(1.0)
    assert "its odometry does not cover the time of its scans" in read_log(talk.write(tmp_path, "mcap")).report


def test_an_mcap_alone_in_a_folder_is_found(tmp_path: Path, talk: Talk) -> None:
    talk.write(tmp_path, "mcap")
    assert len(read_log(tmp_path)) == 5


def test_a_folder_that_is_not_a_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="not a file"):
        read_log(tmp_path)
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: 5\n")
    with pytest.raises(LogError, match="not a ROS 2 bag"):
        read_log(tmp_path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=60)
@given(st.binary(max_size=50), st.integers(8, 6000), st.integers(0, 60))
def test_damage_is_at_most_a_log_error(tmp_path: Path, talk: Talk, junk: bytes, first: int, removed: int) -> None:
    path = tmp_path / "run.mcap"
    if not path.exists():
        talk.write(tmp_path, "mcap")
        (tmp_path / "whole").write_bytes(path.read_bytes())
    whole = (tmp_path / "whole").read_bytes()
    path.write_bytes(whole[:first] + junk + whole[first + removed :])
    with suppress(LogError):
        assert len(read_log(path)) <= 5


@given(st.lists(st.tuples(st.integers(0, 50), st.floats(-3, 3)), min_size=1, max_size=12))
def test_a_track_goes_through_its_poses(points: Sequence[tuple[int, float]]) -> None:
    poses = {float(stamp): Pose2D(value, -value, value) for stamp, value in reversed(points)}
    track = PoseSeries.of_poses(list(poses.items()))
    at = track.poses_at(np.array(sorted(poses)))
    for row, stamp in zip(at, sorted(poses), strict=True):
        assert row[:2] == pytest.approx([poses[stamp].x, poses[stamp].y])
        assert np.cos(row[2] - poses[stamp].theta) == pytest.approx(1.0)
