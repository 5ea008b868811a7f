"""A bus to the nodes of ROS 2 through Cyclone DDS."""

import logging
import threading
from collections.abc import Callable
from functools import cache
from typing import Any, Final, Self

from slam.errors import InputError
from slam.files.ros.messages import ros2_types
from slam.named_code import import_optional
from slam.topics.dds_types import EXTRA, open_dds_topic, without_description
from slam.topics.rclpy_bus import RclpyBus, has_ros
from slam.topics.ros_network import RosNetwork
from slam.topics.topic import Bus, Topic

_LOG: Final = logging.getLogger("hopslam.ros")
_SENT: Final = 100
"""Messages of a topic that may wait for a slow reader; of a latched one, only the last."""
_HEARD: Final = 1000
"""Messages that may wait for this program, whose listeners pause during compilation."""
_AT_ONCE: Final = 64
"""Messages that are taken at once."""
_FOREVER: Final = 2**63 - 1
"""Nanoseconds that DDS takes as infinite."""


def open_ros_bus() -> Bus:
    """Return a bus to the ROS 2 nodes in the environment's domain; enter it to use it.

    It uses rclpy if a ROS is sourced that this Python can import, and otherwise Cyclone DDS. InputError if Cyclone DDS
    is not installed, or for invalid environment variables.
    """
    return RclpyBus() if has_ros() else RosBus(RosNetwork.from_environment())


class RosBus:
    """Topics of ROS 2, by DDS. Messages of this process do not come back to it.

    If nobody takes messages, the oldest are dropped.
    """

    def __init__(self, network: RosNetwork) -> None:
        self._network = network
        self._dds = import_optional("cyclonedds.core", EXTRA)
        self._participant: Any = None
        self._over: Any = None
        """Condition that ends all listeners."""
        self._writers: dict[Topic, Any] = {}
        self._listeners: list[threading.Thread] = []

    def __enter__(self) -> Self:
        """Join the domain; InputError if that fails."""
        domain = import_optional("cyclonedds.domain", EXTRA)
        try:
            _open_domain(self._network)
            self._participant = domain.DomainParticipant(self._network.domain)
        except self._dds.DDSException as error:
            raise InputError(f"ROS domain {self._network.domain} cannot be joined: {error}; see docs/ros.md") from error
        self._over = self._dds.GuardCondition(self._participant)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the domain, and stop all listeners."""
        self._over.set(True)
        for listener in self._listeners:
            listener.join()
        self._listeners.clear()
        self._writers.clear()
        self._over = self._participant = None

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        """Send a message to all listeners; a latched topic keeps it for later ones.

        It is dropped if it would have to wait for a reader.
        """
        if topic not in self._writers:
            self._writers[topic] = self._open("pub", "DataWriter", topic, 1 if topic.latched else _SENT)
        writer = self._writers[topic]
        try:
            writer.write(writer.data_type(message))
        except self._dds.DDSException as error:
            _LOG.debug("%s: a message of %d bytes is dropped: %s", topic.name, len(message), error)

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        """Call ``heard``, in a separate thread, with each message of another program."""
        reader = self._open("sub", "DataReader", topic, _HEARD)
        listener = threading.Thread(target=self._listen, args=(reader, heard), name=f"ROS {topic.name}", daemon=True)
        self._listeners.append(listener)
        listener.start()

    def _open(self, module: str, kind: str, topic: Topic, depth: int) -> Any:
        """Return the reader or writer of a topic, with a queue of this length."""
        dds_topic = open_dds_topic(self._participant, topic.name, topic.type)
        make = getattr(import_optional(f"cyclonedds.{module}", EXTRA), kind)
        with without_description(dds_topic):
            return make(self._participant, dds_topic, self._quality(topic, depth))

    def _quality(self, topic: Topic, depth: int) -> Any:
        """Return the quality of service of the topic. A writer never waits: see ``max_blocking_time``."""
        policy = self._dds.Policy
        return self._dds.Qos(
            policy.Reliability.Reliable(max_blocking_time=0) if topic.reliable else policy.Reliability.BestEffort,
            policy.Durability.TransientLocal if topic.latched else policy.Durability.Volatile,
            policy.History.KeepLast(depth),
            policy.DataRepresentation(use_cdrv0_representation=True),
            policy.IgnoreLocal.Process,
            policy.Userdata(f"typehash={ros2_types().hash_rihs01(topic.type)};".encode()),  # as of Iron: REP 2016
        )

    def _listen(self, reader: Any, heard: Callable[[bytes], None]) -> None:
        dds, over = self._dds, self._over
        waiting = dds.WaitSet(self._participant)
        news = dds.ReadCondition(reader, dds.ViewState.Any | dds.InstanceState.Any | dds.SampleState.NotRead)
        waiting.attach(news)
        waiting.attach(over)
        while not over.read():
            waiting.wait(_FOREVER)
            for sample in reader.take(_AT_ONCE):
                if sample.sample_info.valid_data:
                    heard(sample.data)


@cache
def _open_domain(network: RosNetwork) -> Any:
    """Return the domain of DDS, which exists until the process ends: all its buses share it."""
    return import_optional("cyclonedds.domain", EXTRA).Domain(network.domain, network.cyclone_config)


_: type[Bus] = RosBus
