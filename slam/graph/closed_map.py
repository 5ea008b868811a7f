"""The map rebuilt: all key scans, at their poses in the graph, added to an empty or a saved map."""

from collections.abc import Iterable

import numpy as np

from slam.graph.key_scan import KeyScan
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D, wrap_angle


class ClosedMap:
    """A map that is written from key scans alone."""

    def __init__(self, surfel_map: SurfelMap) -> None:
        self.map = surfel_map
        self._last: FloatArray | None = None

    def add(self, key: KeyScan, T_map_laser: FloatArray) -> None:
        """Add a key scan to the map."""
        moved = 0.0
        if self._last is not None:
            offset = T_map_laser - self._last
            moved = float(np.hypot(offset[0], offset[1])) + abs(wrap_angle(float(offset[2])))
        self._last = T_map_laser
        self.map.add(key.facets, key.scan, Pose2D.from_array(T_map_laser), moved)


def map_of(keys: Iterable[tuple[KeyScan, FloatArray]], empty: SurfelMap) -> SurfelMap:
    """Write key scans with their poses (3,) into an empty or saved map, and return it."""
    made = ClosedMap(empty)
    for key, T_map_laser in keys:
        made.add(key, T_map_laser)
    return made.map
