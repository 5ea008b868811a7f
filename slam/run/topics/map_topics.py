"""``/map`` and ``/lines``, published by a thread of their own, so that no scan waits for them."""

import logging
from queue import SimpleQueue
from threading import Thread
from time import monotonic
from typing import Final

import numpy as np

from slam.closing import Closing
from slam.config import SlamConfig
from slam.errors import InputError
from slam.files.ros.live_encoder import LiveEncoder
from slam.pose import FloatArray, Pose2D
from slam.run.occupancy import Occupancy
from slam.run.step import Step
from slam.run.topics.live_map import LiveMap
from slam.topics.names import LINES, MAP
from slam.topics.topic import Bus

_LOG: Final = logging.getLogger("hopslam.topics")
PERIOD: Final = 2.0
"""Seconds between two maps at least."""


class MapTopics(Closing):
    """Sends the occupancy grid and the lines whenever they have changed, but not more often than PERIOD."""

    def __init__(self, bus: Bus, config: SlamConfig, T_base_laser: Pose2D) -> None:
        self._bus, self._encoder = bus, LiveEncoder()
        self._map: LiveMap | None = LiveMap(config, T_base_laser)
        self._ends = np.empty((0, 2, 2))  # as sent last
        self._map_due, self._changed = 0.0, False
        self._news: SimpleQueue[tuple[Step, FloatArray | None] | None] = SimpleQueue()
        self._thread = Thread(target=self._follow, name="map topics", daemon=True)
        self._thread.start()

    def add(self, step: Step, ends: FloatArray | None) -> None:
        """Take a step, and the lines (N, 2, 2) where it is time to show them; never waits."""
        self._news.put((step, ends))

    def close(self) -> None:
        """Do what waits, and end the thread."""
        self._news.put(None)
        self._thread.join()

    def send_map(self, stamp: float, grid: Occupancy) -> None:
        """Send this grid."""
        self._bus.publish(MAP, stamp, self._encoder.grid(stamp, grid.cells, grid.corner, grid.cell))

    def send_lines(self, stamp: float, ends: FloatArray) -> None:
        """Send these lines where they are not those that were sent last."""
        if not np.array_equal(ends, self._ends):
            self._ends = ends
            self._bus.publish(LINES, stamp, self._encoder.lines(stamp, ends))

    def _follow(self) -> None:
        while (news := self._news.get()) is not None:
            step, ends = news
            if self._map is not None:
                self._follow_map(self._map, step)
            if ends is not None:
                self.send_lines(step.estimate.stamp, ends)

    def _follow_map(self, live: LiveMap, step: Step) -> None:
        try:
            self._changed |= live.add(step)
        except InputError as excess:
            self._map = None
            _LOG.warning("/map is not sent any more: %s", excess)
            return
        if self._changed and monotonic() >= self._map_due and live.grid is not None:
            self._changed, self._map_due = False, monotonic() + PERIOD
            self.send_map(step.estimate.stamp, live.grid)
