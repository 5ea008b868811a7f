"""The network of a ROS 2 bus, and two programs on it."""

import os
import subprocess
import sys
from typing import ClassVar, Self

import pytest

from slam.errors import InputError
from slam.topics import names, rclpy_bus
from slam.topics.ros_bus import open_ros_bus
from slam.topics.ros_network import RosNetwork
from slam.topics.topic import Topic

ECHO = """
import sys, threading
from slam.topics.ros_bus import open_ros_bus
from slam.topics.topic import Topic

said, hears, message = Topic(sys.argv[1], "std_msgs/msg/String"), Topic(sys.argv[2], "std_msgs/msg/String"), sys.argv[3]
heard, own, news = [], [], threading.Event()
with open_ros_bus() as bus:
    bus.subscribe(said, own.append)
    bus.subscribe(hears, lambda message: (heard.append(message), news.set()))
    while not news.wait(0.05):
        bus.publish(said, 0.0, bytes.fromhex(message))
    bus.publish(said, 0.0, bytes.fromhex(message))
assert not own
print(heard[0].hex())
"""
"""A program that publishes bytes until it hears some, and prints them."""
AGAIN = """
from slam.topics import names
from slam.topics.ros_bus import open_ros_bus

for _ in range(5):
    with open_ros_bus() as bus:
        for topic in (names.SCAN, names.ODOM, names.TF, names.TF_STATIC):
            bus.subscribe(topic, print)
        bus.publish(names.CLOCK, 0.0, bytes(12))
"""
"""A program that opens one bus after another, as an environment does that is made again."""


def test_by_default_a_node_stays_on_this_machine() -> None:
    network = RosNetwork.from_environment({})
    assert (network.domain, network.this_machine) == (0, True)
    assert "127.0.0.1" in network.cyclone_config


def test_the_environment_variables_of_ros_are_used() -> None:
    environment = {"ROS_DOMAIN_ID": "42", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": "a;b"}
    network = RosNetwork.from_environment(environment)
    assert (network.domain, network.this_machine, network.peers) == (42, False, ("a", "b"))
    assert "127.0.0.1" not in network.cyclone_config
    assert RosNetwork.from_environment(environment | {"ROS_LOCALHOST_ONLY": "1"}).this_machine
    assert RosNetwork.from_environment({"CYCLONEDDS_URI": "<x/>"}).cyclone_config == "<x/>"


@pytest.mark.parametrize(("name", "value"), [
    ("ROS_DOMAIN_ID", "-1"), ("ROS_DOMAIN_ID", "233"), ("ROS_DOMAIN_ID", "x"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
])  # fmt: skip
def test_unusable_variables_are_named(name: str, value: str) -> None:
    with pytest.raises(InputError, match=f"{name}={value}"):
        RosNetwork.from_environment({name: value})


def test_a_missing_package_names_its_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cyclonedds.core", None)
    with pytest.raises(InputError, match=r"pip install 'hopslam\[ros\]'"):
        open_ros_bus()


def test_two_programs_exchange_messages(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("cyclonedds", reason="Cyclone DDS is not installed: pip install 'hopslam[ros]'")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(100 + os.getpid() % 100))
    hello, world = "000100000600000048656c6c6f000000", "0001000006000000576f726c64000000"
    programs = [
        subprocess.Popen([sys.executable, "-c", ECHO, *words], stdout=subprocess.PIPE, text=True)
        for words in (("/here", "/there", hello), ("/there", "/here", world))
    ]
    assert [program.communicate(timeout=60)[0].strip() for program in programs] == [world, hello]


def test_a_bus_can_be_opened_after_another(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("cyclonedds", reason="Cyclone DDS is not installed: pip install 'hopslam[ros]'")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(100 + os.getpid() % 100))
    assert subprocess.run([sys.executable, "-c", AGAIN], timeout=120).returncode == 0


class FakeNode:
    """A node of rclpy that notes what it is asked to hear."""

    made: ClassVar[list[Self]] = []

    def __init__(self) -> None:
        self.types: dict[str, str] = {}
        self.heard: list[Topic] = []
        self.made.append(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.heard.clear()

    def subscribe(self, topic: Topic, heard: object) -> None:
        self.heard.append(topic)


def test_one_name_of_two_types_takes_two_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rclpy_bus, "_Node", FakeNode)
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    with rclpy_bus.RclpyBus() as bus:
        for topic in (names.CMD_VEL, names.TF, names.STAMPED_CMD_VEL, names.SCAN):
            bus.subscribe(topic, print)
        assert [node.heard for node in FakeNode.made] == [
            [names.CMD_VEL, names.TF, names.SCAN],
            [names.STAMPED_CMD_VEL],
        ]
    assert not any(node.heard for node in FakeNode.made)


def test_a_sourced_ros_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not rclpy_bus.has_ros()
    monkeypatch.setattr(rclpy_bus, "find_spec", lambda package: package)
    assert isinstance(open_ros_bus(), rclpy_bus.RclpyBus)
