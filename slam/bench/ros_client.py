"""A node of rclpy, run by the Python of a ROS 2, not that of hopslam: the other end of benchmark and tests.

``ros_client.py listen SECONDS``, ``record SECONDS``, ``drive SECONDS [stamped]``, ``flood SECONDS``, ``sleep SECONDS``
or ``play FILE [RATE]``. Each prints one line of JSON at its end; the first three also end when their input is closed.
"""

import functools
import json
import os
import random
import select
import sys
import time
from pathlib import Path
from typing import Any, Final

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import LaserScan

_LATCHED: Final = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_REST: Final = 1.0
"""Seconds for which messages are still taken after the input is closed."""
_DEPTH: Final = 100
"""Messages that may wait for this program, or for its readers."""


def listen(node: Any, seconds: str) -> dict[str, Any]:
    """Record the stamps and ages of all scans, with a reliable connection; and the last map."""
    stamps: list[float] = []
    ages: list[float] = []
    grid: dict[str, Any] = {}

    def hear(scan: Any, info: dict[str, Any]) -> None:
        ages.append(1e-9 * (time.time_ns() - info["source_timestamp"]))
        stamps.append(scan.header.stamp.sec + 1e-9 * scan.header.stamp.nanosec)

    def hear_map(message: Any) -> None:
        info = message.info
        grid.update(width=info.width, height=info.height, x=info.origin.position.x, y=info.origin.position.y)
        grid.update(resolution=info.resolution, cells=bytes(cell & 0xFF for cell in message.data).hex())

    node.create_subscription(LaserScan, "/scan", hear, _DEPTH)
    node.create_subscription(OccupancyGrid, "/map", hear_map, _LATCHED)
    _spin(node, float(seconds))
    return {"stamps": stamps, "ages": ages, "map": grid}


def record(node: Any, seconds: str) -> dict[str, Any]:
    """Keep the bytes of all scans and odometry, in the order of arrival."""
    heard: list[tuple[str, str]] = []
    for kind, topic in ((LaserScan, "/scan"), (Odometry, "/odom")):
        hear = functools.partial(lambda name, message: heard.append((name, message.hex())), topic)
        node.create_subscription(kind, topic, hear, _DEPTH, raw=True)
    _spin(node, float(seconds))
    return {"messages": heard}


def drive(node: Any, seconds: str, stamped: str = "") -> dict[str, Any]:
    """Drive by /cmd_vel where there is room, a command for each scan, and report their number."""
    commands = [0]
    publisher = node.create_publisher(TwistStamped if stamped else Twist, "/cmd_vel", 10)

    def hear(scan: Any) -> None:
        middle = len(scan.ranges) // 2
        ahead = [reading for reading in scan.ranges[middle - 60 : middle + 60] if reading > scan.range_min]
        command = TwistStamped() if stamped else Twist()
        twist = command.twist if stamped else command
        if min(ahead, default=0.0) > 0.8:
            twist.linear.x = 0.3
        else:
            twist.angular.z = 0.6
        publisher.publish(command)
        commands[0] += 1

    node.create_subscription(LaserScan, "/scan", hear, 10)
    _spin(node, float(seconds))
    return {"commands": commands[0]}


def flood(node: Any, seconds: str) -> dict[str, Any]:
    """Send invalid bytes as fast as possible, and impossible velocities."""
    publisher, until, sent = node.create_publisher(Twist, "/cmd_vel", 10), time.time() + float(seconds), 0
    wild = Twist()
    wild.linear.x = wild.angular.z = float("nan")
    while time.time() < until:
        publisher.publish(b"\0\1\0\0" + os.urandom(random.randrange(200)))
        publisher.publish(wild)
        sent += 2
    return {"sent": sent}


def sleep(node: Any, seconds: str) -> dict[str, Any]:
    """Subscribe to all scans, and read none."""
    node.create_subscription(LaserScan, "/scan", print, _DEPTH)
    time.sleep(float(seconds))
    return {}


def play(node: Any, file: str, rate: str = "10") -> dict[str, Any]:
    """Publish the messages of a file, lines of topic, type and hexadecimal CDR, with a pause before each scan."""
    kinds = {"sensor_msgs/msg/LaserScan": LaserScan, "nav_msgs/msg/Odometry": Odometry}
    lines = [line.split() for line in Path(file).read_text().splitlines()]
    publishers = {topic: node.create_publisher(kinds[kind], topic, _DEPTH) for topic, kind, _ in lines}
    while not all(publisher.get_subscription_count() for publisher in publishers.values()):
        time.sleep(0.05)
    time.sleep(2.0)  # the other side must have found this one too
    for topic, kind, data in lines:
        if kind.endswith("LaserScan"):
            time.sleep(1.0 / float(rate))
        publishers[topic].publish(bytes.fromhex(data))
    time.sleep(1.0)
    return {"sent": len(lines)}


def _spin(node: Any, seconds: float) -> None:
    """Take messages for this time, or until shortly after the input is closed."""
    until, closed = time.time() + seconds, False
    while time.time() < until:
        rclpy.spin_once(node, timeout_sec=0.1)
        if not closed and select.select([sys.stdin], [], [], 0.0)[0]:
            closed, until = True, min(until, time.time() + _REST)


if __name__ == "__main__":
    rclpy.init()
    node = rclpy.create_node("hopslam_client")
    print("ready", flush=True)
    print(json.dumps(globals()[sys.argv[1]](node, *sys.argv[2:])), flush=True)
