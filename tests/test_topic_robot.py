"""A robot of ROS 2 topics: its observations, its commands, and its errors."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from slam.errors import RobotError, RobotTimeout
from slam.files.logs import read_log
from slam.files.ros.mcap_files import mcap_messages
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.launch import run
from slam.run.replay_robot import ReplayRobot
from slam.run.ros_robot import robot as module
from slam.run.ros_robot.robot import TopicRobot
from slam.scenario.file import load_scenario
from tests.topic_node import MemoryBus, laser_scan, odometry, transform

LASER_SCAN, ODOMETRY, TRANSFORMS = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
RANGES = np.linspace(1.0, 2.0, 181)


def scan(stamp: float, **more: Any) -> Any:
    return laser_scan(stamp, RANGES, -np.pi / 2, np.pi / 180, **more)


class ScriptedBus(MemoryBus):
    """A bus that delivers these messages as soon as a subscriber of scans comes."""

    def __init__(self, *messages: tuple[str, str, Any]) -> None:
        super().__init__()
        self.messages = messages

    def subscribe(self, topic: Any, heard: Callable[[bytes], None]) -> None:
        super().subscribe(topic, heard)
        if topic.type == LASER_SCAN:
            for message in self.messages:
                self.say(*message)


def odom(stamp: float, *pose: float, name: str = "/odom", **more: float) -> tuple[str, str, Any]:
    return name, ODOMETRY, odometry(stamp, *pose, **more)


def seen(stamp: float, name: str = "/scan", **more: Any) -> tuple[str, str, Any]:
    return name, LASER_SCAN, scan(stamp, **more)


def placed(frame: str, child: str, *pose: float, stamp: float = 0.0, name: str = "/tf") -> tuple[str, str, Any]:
    return name, TRANSFORMS, transform(stamp, frame, child, *pose)


MOUNT = placed("base_link", "laser", 0.16, 0.0, 0.0, name="/tf_static")


@contextmanager
def topic_robot(bus: MemoryBus, *settings: str, follows: bool = False) -> Iterator[TopicRobot]:
    with TopicRobot(load_scenario("corridor", settings), bus=bus, follows=follows) as robot:
        if follows:
            robot.meet()
        yield robot


def test_odometry_is_interpolated_at_the_stamp_of_the_scan() -> None:
    bus = ScriptedBus(
        MOUNT, odom(1.0, 5.0, 1.0, 0.0), odom(1.2, 5.2, 1.0, 0.2), seen(1.1), odom(1.4, 5.4, 1.0, 0.4), seen(1.3)
    )
    with topic_robot(bus) as robot:
        first, second = robot.observe(), robot.observe()
    assert first is not None
    assert second is not None
    assert first.odometry.T_odom_base.distance(Pose2D()) < 1e-9
    assert robot.T_odom_start.distance(Pose2D(5.1, 1.0)) < 1e-9
    assert robot.T_odom_start.theta == pytest.approx(0.1)
    at_second = robot.T_odom_start @ second.odometry.T_odom_base
    assert at_second.distance(Pose2D(5.3, 1.0)) < 1e-9
    assert at_second.theta == pytest.approx(0.3)


def test_late_odometry_is_extrapolated() -> None:
    bus = ScriptedBus(MOUNT, odom(0.9, 0.0, 0.0, 0.0), odom(1.0, 0.1, 0.0, 0.0, v=1.0), seen(1.0), seen(1.1))
    with topic_robot(bus) as robot:
        robot.observe()
        second = robot.observe()
    assert second is not None
    assert second.odometry.T_odom_base.x == pytest.approx(0.1)


def test_transforms_replace_missing_odometry_messages() -> None:
    links = [placed("odom", "base_footprint", 0.5 * t, 0.0, 0.0, stamp=t) for t in (1.0, 1.2, 1.4)]
    with topic_robot(ScriptedBus(MOUNT, *links, seen(1.1), seen(1.3))) as robot:
        robot.observe()
        second = robot.observe()
    assert second is not None
    assert second.odometry.T_odom_base.x == pytest.approx(0.1)
    assert second.odometry.twist.linear == pytest.approx(0.5)


def test_topics_can_have_other_names() -> None:
    settings = ["ros.scan_topic=/base/scan", "ros.odom_topic=/wheels", "ros.command_topic=/base/cmd"]
    bus = ScriptedBus(MOUNT, odom(1.0, 0.0, 0.0, 0.0, name="/wheels"), seen(1.0, name="/base/scan"))
    with topic_robot(bus, *settings) as robot:
        assert robot.observe() is not None
        robot.drive(Twist2D(0.1, 0.2))
    assert {name for name, *_ in bus.sent} == {"/base/cmd"}


def test_commands_are_limited_and_the_last_is_a_stop() -> None:
    bus = ScriptedBus(MOUNT, odom(1.0, 0.0, 0.0, 0.0), seen(1.0))
    with topic_robot(bus, "robot.limits.linear=0.7", "robot.limits.angular=1") as robot:
        assert robot.drive(Twist2D(5.0, -5.0)) == Twist2D(0.7, -1.0)
        with pytest.raises(RobotError, match="finite"):
            robot.drive(Twist2D(float("nan"), 0.0))
    assert bus.commands()[0] == (0.7, -1.0)
    assert set(bus.commands()[1:]) == {(0.0, 0.0)}


def test_a_follower_commands_nothing() -> None:
    bus = ScriptedBus(MOUNT, odom(1.0, 0.0, 0.0, 0.0, v=0.3), seen(1.0))
    with topic_robot(bus, follows=True) as robot:
        robot.observe()
        assert robot.drive(Twist2D(1.0, 0.0)) == Twist2D(0.3, 0.0)
        assert robot.T_base_laser == Pose2D(0.16)
    assert not bus.sent


def test_a_follower_keeps_all_scans_and_a_driver_the_last() -> None:
    stamps = 1.0 + 0.1 * np.arange(40)
    bus = ScriptedBus(MOUNT, *(message for t in stamps for message in (odom(t, t, 0.0, 0.0), seen(t))))
    with topic_robot(bus, follows=True) as robot:
        assert [robot.observe().scan.stamp for _ in stamps] == pytest.approx(stamps)
    with topic_robot(bus) as robot:
        assert robot.observe().scan.stamp == pytest.approx(stamps[-4])
    with TopicRobot(load_scenario("corridor"), bus=bus, newest=True) as robot:
        assert robot.observe().scan.stamp == pytest.approx(stamps[-1])


def test_a_lidar_mounted_elsewhere_is_refused() -> None:
    bus = ScriptedBus(
        placed("base_link", "laser", 0.3, 0.0, 0.0, name="/tf_static"), odom(1.0, 0.0, 0.0, 0.0), seen(1.0)
    )
    with pytest.raises(RobotError, match=r"set lidar.mount.x=0.3 lidar.mount.y=0 "), topic_robot(bus):
        pass
    with topic_robot(bus, "lidar.mount.x=0.3"):
        pass


def test_garbage_is_skipped(caplog: pytest.LogCaptureFixture) -> None:
    bad = [(name, kind, bytes([0, 1, 0, 0, *([255] * 30)])) for name, kind, _ in (MOUNT, odom(1.0, 0, 0, 0), seen(1.0))]
    later = odom(1.1, 0.0, 0.0, 0.0), seen(1.05, frame="rear"), seen(1.1)
    with topic_robot(
        ScriptedBus(*bad, MOUNT, odom(1.0, 0.0, 0.0, 0.0), seen(1.0), *bad, *later), follows=True
    ) as robot:
        assert [robot.observe().scan.stamp for _ in range(2)] == [1.0, 1.1]
    assert sum("cannot be read" in line for line in caplog.messages) == 1


def test_a_silent_topic_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_FIRST", 0.05)
    monkeypatch.setattr(module, "_LATE", 0.01)
    with pytest.raises(RobotError, match=r"no scan on /scan for 0\.05 s: .*ROS_DOMAIN_ID"), topic_robot(MemoryBus()):
        pass
    with (
        topic_robot(ScriptedBus(MOUNT, seen(1.0))) as robot,
        pytest.raises(RobotTimeout, match="no odometry on /odom or /tf"),
    ):
        robot.observe(timeout=0.05)
    other = ScriptedBus(MOUNT, odom(900.0, 0.0, 0.0, 0.0), seen(1.0))
    with topic_robot(other) as robot, pytest.raises(RobotTimeout, match=r"is of another time, 900.000 s"):
        robot.observe(timeout=0.05)
    with topic_robot(ScriptedBus(MOUNT, odom(1.0, 0.0, 0.0, 0.0), seen(1.0))) as robot:
        robot.observe()
        with pytest.raises(RobotTimeout, match=r"no scan on /scan for 0\.05 s"):
            robot.observe(timeout=0.05)


def test_observations_are_those_of_a_replay_of_the_log(tmp_path: Path) -> None:
    settings = ["duration=3", "physics.engine=plan", "slam.mode=dead_reckoning"]
    folder = run("corridor", settings=settings, out=tmp_path / "run", pictures=False).folder
    known = ("/scan", "/odom", "/tf_static")
    bus = ScriptedBus(*((m.topic, m.type, m.data) for m in mcap_messages(folder / "log.mcap") if m.topic in known))
    replayed = ReplayRobot(read_log(folder))
    with topic_robot(bus, "duration=100", follows=True) as robot:
        assert robot.T_base_laser == replayed.T_base_laser
        for _ in range(len(replayed)):
            live, logged = robot.observe(), replayed.observe()
            assert live is not None
            assert logged is not None
            assert live.scan.ranges.tobytes() == logged.scan.ranges.tobytes()
            assert (live.scan.stamp, live.scan.angle_min) == (logged.scan.stamp, logged.scan.angle_min)
            assert live.odometry.T_odom_base.distance(logged.odometry.T_odom_base) < 1e-9
            assert live.odometry.twist == logged.odometry.twist
