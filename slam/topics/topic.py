"""A topic, and the Bus protocol that carries messages."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self


@dataclass(frozen=True, slots=True)
class Topic:
    """Name and message type of a topic, and its quality of service."""

    name: str
    """Name, such as ``/scan``."""
    type: str
    """Message type, such as ``sensor_msgs/msg/LaserScan``."""
    reliable: bool = True
    """False for sensor data, of which a late message is useless."""
    latched: bool = False
    """True if late listeners get the last message too."""


class Bus(Protocol):
    """Carries messages, in CDR, to and from other programs. The end of its block closes it."""

    def __enter__(self) -> Self: ...
    def __exit__(self, *_: object) -> None: ...

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        """Send a message without waiting for readers; ``stamp`` is its time in seconds."""
        ...

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        """Call ``heard``, in a thread of the bus, with each message of another program."""
        ...
