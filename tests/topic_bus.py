"""A bus that keeps everything, for tests of what is on topics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Self

from rosbags.typesys import Stores, get_typestore

from slam.topics.topic import Topic

JAZZY = get_typestore(Stores.ROS2_JAZZY)
"""Message types of the newest ROS that rosbags knows; the tested code uses those of an older one."""


@dataclass
class Heard:
    topic: Topic
    stamp: float
    data: bytes

    @property
    def message(self) -> Any:
        return JAZZY.deserialize_cdr(self.data, self.topic.type)


@dataclass
class ListBus:
    """A bus that keeps everything."""

    sent: list[Heard] = field(default_factory=list)
    listeners: list[tuple[Topic, Callable[[bytes], None]]] = field(default_factory=list)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        self.sent.append(Heard(topic, stamp, message))

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        self.listeners.append((topic, heard))

    def of(self, topic: Topic) -> list[Heard]:
        return [heard for heard in self.sent if heard.topic is topic]

    def say(self, topic: Topic, message: bytes) -> None:
        for heard_topic, heard in self.listeners:
            if heard_topic == topic:
                heard(message)
