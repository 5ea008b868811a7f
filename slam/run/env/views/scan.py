"""``scan``: the ranges, always finite."""

from __future__ import annotations

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.run.env.moment import Moment
from slam.scan import LaserScan, Lidar


class ScanView:
    """Ranges (beams,), metres, within [0, range_max]."""

    def __init__(self, lidar: Lidar) -> None:
        self._lidar = lidar

    def space(self) -> Box:
        """[0, range_max] for each beam."""
        return Box(0.0, self._lidar.range_max, (self._lidar.beams,), np.float32)

    def of(self, moment: Moment) -> NDArray[np.float32]:
        """The ranges of this moment."""
        return scan_array(moment.observation.scan)


def scan_array(scan: LaserScan) -> NDArray[np.float32]:
    """The ranges, whatever the sensor said: no echo and an error read ``range_max``, too close reads 0."""
    ranges = np.nan_to_num(scan.ranges, nan=scan.range_max, posinf=scan.range_max, neginf=0.0)
    return np.clip(ranges.astype(np.float32), np.float32(0.0), np.float32(scan.range_max))
