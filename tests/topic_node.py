"""A bus in memory, and a simulated robot on it as a node of ROS 2 would be."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Self

from rosbags.typesys import Stores, get_typestore

from sim.robot import SimRobot
from slam.odometry import Twist2D
from slam.robot import Observation
from slam.scenario.schema import Scenario
from slam.topics.topic import Bus, Topic

ROS = get_typestore(Stores.ROS2_JAZZY)
make = ROS.types.__getitem__


@dataclass
class MemoryBus:
    """One end of a wire: what is published here is heard at the other end."""

    sent: list[tuple[str, str, bytes]] = field(default_factory=list)
    heard_by: list[tuple[Topic, Callable[[bytes], None]]] = field(default_factory=list)
    latched: dict[str, tuple[str, bytes]] = field(default_factory=dict)
    """Latched messages, which late subscribers get too: type and message, by topic."""
    listening: threading.Event = field(default_factory=threading.Event)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.heard_by.clear()
        self.listening.clear()

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        self.sent.append((topic.name, topic.type, message))

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        self.heard_by.append((topic, heard))
        if topic.name in self.latched:
            heard(self.latched[topic.name][1])
        if topic.type == "sensor_msgs/msg/LaserScan":
            self.listening.set()

    def say(self, name: str, kind: str, message: Any) -> None:
        """Send a message, an object or its bytes, from the other end."""
        data = message if isinstance(message, bytes) else bytes(ROS.serialize_cdr(message, kind))
        for topic, heard in list(self.heard_by):
            if (topic.name, topic.type) == (name, kind):
                heard(data)

    def commands(self) -> list[tuple[float, float]]:
        """Velocities that were sent to the other end, m/s and rad/s."""
        twists = [ROS.deserialize_cdr(data, kind) for _, kind, data in self.sent if kind == "geometry_msgs/msg/Twist"]
        return [(twist.linear.x, twist.angular.z) for twist in twists]


_: type[Bus] = MemoryBus


def header(stamp: float, frame: str) -> Any:
    nanoseconds = round(1e9 * stamp)
    time = make("builtin_interfaces/msg/Time")(nanoseconds // 10**9, nanoseconds % 10**9)
    return make("std_msgs/msg/Header")(time, frame)


def laser_scan(stamp: float, ranges: Any, first: float, step: float, frame: str = "laser", **more: float) -> Any:
    limits = {"range_min": 0.02, "range_max": 5.6, "time_increment": 0.0, "scan_time": 0.1} | more
    return make("sensor_msgs/msg/LaserScan")(
        header(stamp, frame), first, first + step * (len(ranges) - 1), step, limits["time_increment"],
        limits["scan_time"], limits["range_min"], limits["range_max"], ranges.astype("float32"),
        ranges[:0].astype("float32"),
    )  # fmt: skip


def turn(theta: float) -> Any:
    from math import cos, sin

    return make("geometry_msgs/msg/Quaternion")(0.0, 0.0, sin(theta / 2.0), cos(theta / 2.0))


def odometry(stamp: float, x: float, y: float, theta: float, v: float = 0.0, w: float = 0.0) -> Any:
    from numpy import zeros

    vector, base = make("geometry_msgs/msg/Vector3"), "base_link"
    pose = make("geometry_msgs/msg/Pose")(make("geometry_msgs/msg/Point")(x, y, 0.0), turn(theta))
    twist = make("geometry_msgs/msg/Twist")(vector(v, 0.0, 0.0), vector(0.0, 0.0, w))
    return make("nav_msgs/msg/Odometry")(
        header(stamp, "odom"), base, make("geometry_msgs/msg/PoseWithCovariance")(pose, zeros(36)),
        make("geometry_msgs/msg/TwistWithCovariance")(twist, zeros(36)),
    )  # fmt: skip


def transform(stamp: float, frame: str, child: str, x: float, y: float, theta: float) -> Any:
    placed = make("geometry_msgs/msg/Transform")(make("geometry_msgs/msg/Vector3")(x, y, 0.0), turn(theta))
    stamped = make("geometry_msgs/msg/TransformStamped")(header(stamp, frame), child, placed)
    return make("tf2_msgs/msg/TFMessage")([stamped])


class SimulatedNode:
    """A thread that moves a simulated robot by one scan at each command, or 0.2 s after the last scan without one."""

    def __init__(self, scenario: Scenario) -> None:
        self.bus = MemoryBus()
        mount = scenario.lidar.mount
        static = transform(0.0, "base_link", "laser", mount.x, mount.y, mount.theta)
        kind = "tf2_msgs/msg/TFMessage"
        self.bus.latched["/tf_static"] = kind, bytes(ROS.serialize_cdr(static, kind))
        self._robot = SimRobot(scenario, seed=1)
        self._commanded, self._over = threading.Event(), threading.Event()
        self._twist = Twist2D()
        self.bus.publish = self._hear  # type: ignore[method-assign]
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._commanded.set()
        self.bus.listening.set()
        self._thread.join()

    def _hear(self, topic: Topic, stamp: float, message: bytes) -> None:
        twist = ROS.deserialize_cdr(message, topic.type)
        self._twist = Twist2D(twist.linear.x, twist.angular.z)
        self._commanded.set()

    def _run(self) -> None:
        with self._robot as robot:
            while not self._over.is_set() and (seen := robot.observe()) is not None:
                self.bus.listening.wait()
                self._commanded.clear()
                self._tell(seen)
                self._commanded.wait(0.2)
                robot.drive(self._twist)

    def _tell(self, seen: Observation) -> None:
        wheels, scan = seen.odometry, seen.scan
        pose, twist = wheels.T_odom_base, wheels.twist
        self.bus.say(
            "/odom", "nav_msgs/msg/Odometry",
            odometry(wheels.stamp, 2.0 + pose.x, pose.y, pose.theta, twist.linear, twist.angular),
        )  # fmt: skip
        more = {name: getattr(scan, name) for name in ("range_min", "range_max", "time_increment", "scan_time")}
        message = laser_scan(scan.stamp, scan.ranges, scan.angle_min, scan.angle_increment, **more)
        self.bus.say("/scan", "sensor_msgs/msg/LaserScan", message)
