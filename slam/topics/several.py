"""Several buses as one."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Self

from slam.topics.topic import Bus, Topic


class SeveralBuses:
    """Sends each message on all of these buses, which may be none, and receives from all of them."""

    def __init__(self, buses: Sequence[Bus]) -> None:
        self._buses, self._open = tuple(buses), ExitStack()

    def __enter__(self) -> Self:
        with ExitStack() as opening:
            for bus in self._buses:
                opening.enter_context(bus)
            self._open = opening.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        """Send a message on all buses."""
        for bus in self._buses:
            bus.publish(topic, stamp, message)

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        """Listen on all buses; ``heard`` may be called in several threads at once."""
        for bus in self._buses:
            bus.subscribe(topic, heard)


_: type[Bus] = SeveralBuses
