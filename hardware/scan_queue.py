"""Scans between the thread that reads them and the program that takes them."""

import threading
import time
from collections import deque
from typing import Final

from slam.scan import LaserScan

_KEPT: Final = 4
"""Scans that may wait; older ones are dropped."""


class ScanQueue:
    """A few scans, oldest first.

    ``scanned_at`` is the monotonic time at which the newest one was complete.
    """

    def __init__(self) -> None:
        self._news = threading.Condition()
        self._scans: deque[LaserScan] = deque(maxlen=_KEPT)
        self.scanned_at = time.monotonic()

    def put(self, scan: LaserScan, whole_at: float) -> None:
        """Append a scan."""
        with self._news:
            self._scans.append(scan)
            self.scanned_at = whole_at
            self._news.notify_all()

    def take(self, timeout: float, newest: bool = False) -> LaserScan | None:
        """Return the oldest scan, or with ``newest`` the newest; None after ``timeout`` seconds."""
        with self._news:
            self._news.wait_for(lambda: self._scans, timeout)
            while newest and len(self._scans) > 1:
                self._scans.popleft()
            return self._scans.popleft() if self._scans else None
