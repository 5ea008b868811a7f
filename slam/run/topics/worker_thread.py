"""A thread that does work which would delay the loop."""

from collections.abc import Callable
from queue import SimpleQueue
from threading import Thread
from time import sleep
from typing import Final, Generic, TypeVar

from slam.closing import Closing

_MAX_WAITING: Final = 1000
"""Items that may wait; if a fast run produces more, it is slowed down."""
_PAUSE: Final = 0.01
"""Seconds."""
Item = TypeVar("Item")


class WorkerThread(Closing, Generic[Item]):
    """Calls ``handle`` with one item after another, on its own thread."""

    def __init__(self, name: str, handle: Callable[[Item], None]) -> None:
        self._handle = handle
        self._items: SimpleQueue[Item | None] = SimpleQueue()
        self._thread = Thread(target=self._follow, name=name, daemon=True)
        self._thread.start()

    def put(self, item: Item) -> None:
        """Pass an item to the thread."""
        while self._items.qsize() > _MAX_WAITING and self._thread.is_alive():
            sleep(_PAUSE)
        self._items.put(item)

    def close(self) -> None:
        """Wait until all items are handled; closing twice is allowed."""
        self._items.put(None)
        self._thread.join()

    def _follow(self) -> None:
        while (item := self._items.get()) is not None:
            self._handle(item)
