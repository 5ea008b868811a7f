"""``map``: what SLAM has seen around the robot."""

from __future__ import annotations

from typing import Final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.env.config import EnvConfig
from slam.env.seen_grid import Extent, SeenGrid
from slam.env.step_state import StepState
from slam.pose import FloatArray
from slam.scenario.schema import Scenario

_GREY: Final = np.array([0, 127, 255], np.uint8)
"""Of UNKNOWN, FREE and WALL."""


class MapView:
    """A square of cells (1, n, n) around the estimated pose, heading up: row 0 lies ahead, column 0 to the left.

    0 is unknown, 127 free, 255 a wall. The scans are put together at the poses that SLAM gave when they came.
    """

    def __init__(self, config: EnvConfig, scenario: Scenario, extent: Extent) -> None:
        self._grid = SeenGrid(extent, config.cell)
        self._T_base_laser = scenario.lidar.mount.pose
        self._size = config.map_cells
        self._points = _crop_points(config.map_cells, config.cell)

    def space(self) -> Box:
        """An image of one channel."""
        return Box(0, 255, (1, self._size, self._size), np.uint8)

    def of(self, moment: StepState) -> NDArray[np.uint8]:
        """The square around where the robot believes to be at this moment."""
        self._grid.add(moment.observation.scan, moment.belief @ self._T_base_laser)
        seen = self._grid.at(moment.belief.transform(self._points))
        return _GREY[seen].reshape(1, self._size, self._size)


def _crop_points(size: int, cell: float) -> FloatArray:
    """The middles of the cells of the crop, base frame, shape (size^2, 2), row by row."""
    offsets = (size / 2 - 0.5 - np.arange(size)) * cell
    x, y = np.meshgrid(offsets, offsets, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])
