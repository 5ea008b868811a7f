"""A bus to the nodes of ROS 2 through the rclpy of an installed ROS, with its middleware."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from contextlib import ExitStack
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Final, Self

from slam.topics.topic import Bus, Topic

_NEEDED: Final = (
    "rclpy",
    "geometry_msgs",
    "nav_msgs",
    "rosgraph_msgs",
    "sensor_msgs",
    "tf2_msgs",
    "visualization_msgs",
)
_SENT, _HEARD = 100, 1000
"""Numbers of messages that may wait until a slow reader takes them, and until this program does."""


def has_ros() -> bool:
    """Return True if a ROS 2 for this Python is sourced, with all the messages that hopslam needs."""
    return all(find_spec(package) is not None for package in _NEEDED)


class RclpyBus:
    """Topics of nodes named hopslam. Domain and range are those of ROS's variables; the default range is this machine.

    Unlike on RosBus, this program also hears its own messages.
    """

    def __init__(self) -> None:
        self._nodes: list[_Node] = []
        self._publishers: dict[Topic, Any] = {}
        self._open = ExitStack()

    def __enter__(self) -> Self:
        os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # the default of ROS is SUBNET
        return self

    def __exit__(self, *_: object) -> None:
        """End all nodes."""
        self._open.close()
        self._nodes.clear()
        self._publishers.clear()

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        """Send a message to all listeners; a latched topic keeps it for later ones."""
        if topic not in self._publishers:
            self._publishers[topic] = self._node_for(topic).publisher(topic)
        self._publishers[topic].publish(message)

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        """Call ``heard``, in a thread of a node, with each message on the topic."""
        self._node_for(topic).subscribe(topic, heard)

    def _node_for(self, topic: Topic) -> _Node:
        """Return a node that has the topic with no other type: within a node, Fast DDS allows one type per name."""
        for node in self._nodes:
            if node.types.setdefault(topic.name, topic.type) == topic.type:
                return node
        node = self._open.enter_context(_Node())
        node.types[topic.name] = topic.type
        self._nodes.append(node)
        return node


class _Node:
    """A node with its own context, and a thread that takes its messages."""

    def __init__(self) -> None:
        self.types: dict[str, str] = {}
        """Type of each topic."""
        self._rclpy, self._qos = import_module("rclpy"), import_module("rclpy.qos")
        self._context = self._rclpy.Context()
        self._rclpy.init(context=self._context, signal_handler_options=self._rclpy.SignalHandlerOptions.NO)
        self._node = self._rclpy.create_node("hopslam", context=self._context)
        self._executor = import_module("rclpy.executors").SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._executor.spin, name="rclpy", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown()
        self._thread.join()
        self._node.destroy_node()
        self._context.try_shutdown()

    def publisher(self, topic: Topic) -> Any:
        """Return a publisher of bytes on the topic."""
        return self._node.create_publisher(_message(topic), topic.name, self._quality(topic, _SENT))

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        """Call ``heard`` with each message, in bytes."""
        self._node.create_subscription(_message(topic), topic.name, heard, self._quality(topic, _HEARD), raw=True)
        self._executor.wake()

    def _quality(self, topic: Topic, depth: int) -> Any:
        qos = self._qos
        return qos.QoSProfile(
            depth=1 if topic.latched and depth == _SENT else depth,
            reliability=qos.ReliabilityPolicy.RELIABLE if topic.reliable else qos.ReliabilityPolicy.BEST_EFFORT,
            durability=qos.DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else qos.DurabilityPolicy.VOLATILE,
        )


def _message(topic: Topic) -> Any:
    package, kind, name = topic.type.split("/")
    return getattr(import_module(f"{package}.{kind}"), name)


_: type[Bus] = RclpyBus
