"""``scan``: the ranges, always finite."""

from __future__ import annotations

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.env.step_state import StepState
from slam.run.arrays import scan_array, scan_space
from slam.scan import Lidar


class ScanView:
    """Ranges (beams,), metres, within [0, range_max]."""

    def __init__(self, lidar: Lidar) -> None:
        self._lidar = lidar

    def space(self) -> Box:
        """[0, range_max] for each beam."""
        return scan_space(self._lidar)

    def of(self, moment: StepState) -> NDArray[np.float32]:
        """The ranges of this moment."""
        return scan_array(moment.observation.scan)
