"""``/map`` and ``/lines``, published by a separate thread, so that no scan is delayed."""

import logging
from time import monotonic
from typing import Final

import numpy as np

from slam.closing import Closing
from slam.config import SlamConfig
from slam.errors import InputError
from slam.files.ros.live_encoder import LiveEncoder
from slam.pose import FloatArray, Pose2D
from slam.run.occupancy import Occupancy, occupancy
from slam.run.results.run_record import RunRecord
from slam.run.step import Step
from slam.run.topics.live_map import LiveMap
from slam.run.topics.worker_thread import WorkerThread
from slam.topics.names import LINES, MAP
from slam.topics.topic import Bus

_LOG: Final = logging.getLogger("hopslam.topics")
PERIOD: Final = 2.0
"""Least time between two maps, seconds."""
_MAX_LINES: Final = 4000
"""Largest number of lines that are sent: paper mode keeps those of every scan."""


class MapTopics(Closing):
    """Sends the occupancy grid and the lines after changes, but not more often than every PERIOD."""

    def __init__(self, bus: Bus, config: SlamConfig, T_base_laser: Pose2D) -> None:
        self._bus, self._encoder = bus, LiveEncoder()
        self._map: LiveMap | None = LiveMap(config, T_base_laser)
        self._ends = np.empty((0, 2, 2))  # as last sent
        self._map_due, self._changed = 0.0, False
        self._thread: WorkerThread[tuple[Step, FloatArray | None]] = WorkerThread("map topics", self._follow)

    def add(self, step: Step, ends: FloatArray | None) -> None:
        """Take a step, and the lines (N, 2, 2) when they are due."""
        self._thread.put((step, ends))

    def close(self) -> None:
        """Do the waiting work, and end the thread."""
        self._thread.close()

    def send_end(self, stamp: float, record: RunRecord) -> None:
        """Send the map of a finished run, unless it has become too large."""
        self._send_lines(stamp, record.walls)
        if self._map is not None:
            self._send_map(stamp, occupancy(record))

    def _follow(self, news: tuple[Step, FloatArray | None]) -> None:
        step, ends = news
        if self._map is not None:
            self._follow_map(self._map, step)
        if ends is not None:
            self._send_lines(step.estimate.stamp, ends)

    def _follow_map(self, live: LiveMap, step: Step) -> None:
        try:
            self._changed |= live.add(step)
        except InputError as excess:
            self._map = None
            _LOG.warning("/map is not sent any more: %s", excess)
            return
        if self._changed and monotonic() >= self._map_due and live.grid is not None:
            self._changed, self._map_due = False, monotonic() + PERIOD
            self._send_map(step.estimate.stamp, live.grid)

    def _send_map(self, stamp: float, grid: Occupancy) -> None:
        self._bus.publish(MAP, stamp, self._encoder.grid(stamp, grid.cells, grid.corner, grid.cell))

    def _send_lines(self, stamp: float, ends: FloatArray) -> None:
        """Send these lines, every n-th if they are too many, unless they were the last ones sent."""
        if not np.array_equal(ends, self._ends):
            self._ends = ends
            shown = ends[:: len(ends) // _MAX_LINES + 1]
            self._bus.publish(LINES, stamp, self._encoder.lines(stamp, shown))
