"""A thread that does work which would delay the loop."""

from collections.abc import Callable
from queue import SimpleQueue
from threading import Thread
from time import sleep
from typing import Final, Generic, TypeVar

from slam.closing import Closing

_MOST: Final = 1000
"""Items that may wait; if a fast run produces more, it is slowed down."""
_PAUSE: Final = 0.01
"""Seconds."""
News = TypeVar("News")


class NewsThread(Closing, Generic[News]):
    """Calls ``handle`` with one item after another, on its own thread."""

    def __init__(self, name: str, handle: Callable[[News], None]) -> None:
        self._handle = handle
        self._news: SimpleQueue[News | None] = SimpleQueue()
        self._thread = Thread(target=self._follow, name=name, daemon=True)
        self._thread.start()

    def put(self, news: News) -> None:
        """Pass an item to the thread."""
        while self._news.qsize() > _MOST and self._thread.is_alive():
            sleep(_PAUSE)
        self._news.put(news)

    def close(self) -> None:
        """Wait until all items are handled; closing twice is allowed."""
        self._news.put(None)
        self._thread.join()

    def _follow(self) -> None:
        while (news := self._news.get()) is not None:
            self._handle(news)
