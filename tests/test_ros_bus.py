"""The network that a bus of ROS 2 joins, and two programs on it."""

import subprocess
import sys

import pytest

from slam.errors import InputError
from slam.topics.ros_bus import open_ros_bus
from slam.topics.ros_network import RosNetwork

ECHO = """
import sys, threading
from slam.topics.ros_bus import open_ros_bus
from slam.topics.topic import Topic

type, other, latched, mine = sys.argv[1], sys.argv[2], sys.argv[3] == "latched", sys.argv[4] == "first"
here, there = Topic("/here", type, latched=latched), Topic("/there", type, latched=latched)
heard, echoed = threading.Event(), []
with open_ros_bus() as bus:
    bus.subscribe(there if mine else here, lambda message: (echoed.append(message), heard.set()))
    while not heard.wait(0.05):
        bus.publish(here if mine else there, 0.0, bytes.fromhex(other))
    bus.publish(here if mine else there, 0.0, bytes.fromhex(other))
    print(echoed[0].hex())
"""
"""A program that publishes bytes until it hears some, and prints them."""


def test_by_default_a_node_stays_on_this_machine() -> None:
    network = RosNetwork.from_environment({})
    assert (network.domain, network.this_machine) == (0, True)
    assert "127.0.0.1" in network.cyclone_config


def test_the_variables_of_ros_are_heeded() -> None:
    told = {"ROS_DOMAIN_ID": "42", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": "a;b"}
    network = RosNetwork.from_environment(told)
    assert (network.domain, network.this_machine, network.peers) == (42, False, ("a", "b"))
    assert "127.0.0.1" not in network.cyclone_config
    assert RosNetwork.from_environment(told | {"ROS_LOCALHOST_ONLY": "1"}).this_machine
    assert RosNetwork.from_environment({"CYCLONEDDS_URI": "<x/>"}).cyclone_config == "<x/>"


@pytest.mark.parametrize(("name", "value"), [
    ("ROS_DOMAIN_ID", "-1"), ("ROS_DOMAIN_ID", "233"), ("ROS_DOMAIN_ID", "x"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
])  # fmt: skip
def test_what_cannot_be_used_is_named(name: str, value: str) -> None:
    with pytest.raises(InputError, match=f"{name}={value}"):
        RosNetwork.from_environment({name: value})


def test_a_missing_package_names_its_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cyclonedds.core", None)
    with pytest.raises(InputError, match=r"pip install 'hopslam\[ros\]'"):
        open_ros_bus()


@pytest.mark.parametrize("latched", ["latched", "volatile"])
def test_two_programs_hear_each_other(latched: str) -> None:
    pytest.importorskip("cyclonedds", reason="Cyclone DDS is not installed: pip install 'hopslam[ros]'")
    hello, world = ("00010000060000004865" + "6c6c6f000000", "0001000006000000576f" + "726c64000000")
    programs = [
        subprocess.Popen(
            [sys.executable, "-c", ECHO, "std_msgs/msg/String", said, latched, order],
            stdout=subprocess.PIPE, text=True,
        )
        for said, order in ((hello, "first"), (world, "second"))
    ]  # fmt: skip
    assert [program.communicate(timeout=30)[0].strip() for program in programs] == [world, hello]
