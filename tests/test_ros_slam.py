"""SLAM as a ROS 2 node gives the result of a replay of its log."""

import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from slam.errors import InputError
from slam.files.ros.decoder import decode_transforms
from slam.files.ros.mcap_files import mcap_messages
from slam.files.ros.messages import RawMessage
from slam.files.tum import read_tum
from slam.pose import Pose2D
from slam.run.launch import follow, replay, run
from slam.topics.topic import Topic
from tests.topic_node import ROS, MemoryBus

TRANSFORMS = "tf2_msgs/msg/TFMessage"
T_odom_start = Pose2D(3.0, -2.0, 1.0)
"""Start of the robot in the frame of its odometry."""


class RecordedRobot(MemoryBus):
    """The topics of a log, on a robot whose odometry began elsewhere. SIGINT follows SLAM's pose for the last scan."""

    def __init__(self, log: Path) -> None:
        super().__init__()
        self.messages = [m for m in mcap_messages(log) if m.topic in ("/scan", "/odom", "/tf_static")]
        self.scans = sum(message.topic == "/scan" for message in self.messages)

    def subscribe(self, topic: Topic, heard: Any) -> None:
        super().subscribe(topic, heard)
        if topic.name == "/scan":
            for message in self.messages:
                self.say(
                    message.topic, message.type, self._moved(message) if message.topic == "/odom" else message.data
                )

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        super().publish(topic, stamp, message)
        if topic.name == "/slam_pose":
            self.scans -= 1
            if self.scans == 0:
                os.kill(os.getpid(), signal.SIGINT)

    def _moved(self, message: RawMessage) -> Any:
        odometry = ROS.deserialize_cdr(message.data, message.type)
        pose = odometry.pose.pose
        turned = T_odom_start @ Pose2D(
            pose.position.x, pose.position.y, 2.0 * np.arctan2(pose.orientation.z, pose.orientation.w)
        )
        pose.position.x, pose.position.y = turned.x, turned.y
        pose.orientation.z, pose.orientation.w = np.sin(turned.theta / 2.0), np.cos(turned.theta / 2.0)
        return odometry


def test_the_node_gives_the_result_of_a_replay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = run("corridor", settings=["duration=4", "physics.engine=plan"], out=tmp_path / "robot", pictures=False)
    bus = RecordedRobot(robot.folder / "log.mcap")
    monkeypatch.setattr("slam.run.ros_robot.robot.open_ros_bus", lambda: bus)
    monkeypatch.setattr("slam.run.topics.topic_choice.open_ros_bus", lambda: bus)

    replayed = replay(robot.folder, scenario="replay", out=tmp_path / "replay", pictures=False)
    followed = follow(out=tmp_path / "node", pictures=False, check=False)

    assert followed.ending == "interrupted"
    (stamps, node), (known, log) = (read_tum(made.folder / "trajectory.tum") for made in (followed, replayed))
    assert_allclose(stamps, known, atol=1e-6)
    assert_allclose(node, log, atol=1e-3)
    links = [
        link
        for name, kind, data in bus.sent
        if name == "/tf"
        for link in decode_transforms(RawMessage(name, kind, "cdr", data, 0))
    ]
    assert {(link.frame, link.child) for link in links} == {("map", "odom")}
    first = links[0].pose @ T_odom_start
    assert first.distance(Pose2D()) < 1e-6
    assert not any(name in ("/scan", "/odom", "/clock", "/cmd_vel") for name, *_ in bus.sent)


def test_localization_needs_a_map() -> None:
    with pytest.raises(InputError, match="--map"):
        follow(keep_map=True)
