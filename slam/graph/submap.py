"""Submaps: consecutive key scans that were matched to one map, and these maps, rebuilt on request."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from slam.config import SurfelMapConfig
from slam.graph.key_scan import KeyScan
from slam.graph.place_search import Pictures, draw_submap
from slam.mapping.surfel_grid import Grid
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D

REACH: Final = 15.0
"""Greatest distance from the path, metres, at which walls count in the search for loops."""
KEPT: Final = 16
"""Number of maps of submaps kept in memory; others are rebuilt from their key scans."""


@dataclass(slots=True, eq=False)
class Submap:
    """Consecutive key scans, which move as one rigid body when the graph of submaps is solved."""

    number: int
    node: int
    T_local_submap: FloatArray
    """(3,): pose of its first key scan."""
    broken: bool
    """True if only odometry connects it to the previous submap."""
    keys: list[int] = field(default_factory=list)
    """Indices of its key scans."""
    path: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    """Poses of its key scans (K, 3) in its frame ``local``, once it is finished."""

    middle: FloatArray = field(default_factory=lambda: np.zeros(2))
    """(2,): mean position of its path."""
    radius: float = 0.0
    """Largest distance of its path from there, metres."""

    def finish(self, keys: Sequence[KeyScan]) -> None:
        """Set the path and its extent, once the submap has all its key scans."""
        self.path = np.array([keys[number].T_local_laser for number in self.keys])
        self.middle = self.path[:, :2].mean(axis=0)
        self.radius = float(np.hypot(*(self.path[:, :2] - self.middle).T).max())


class SubmapMap(NamedTuple):
    """The map of a submap, in the frame ``local`` of its key scans."""

    grid: Grid
    pictures: Pictures


class SubmapMaps:
    """The maps of finished submaps."""

    def __init__(self, config: SurfelMapConfig, keys: Sequence[KeyScan]) -> None:
        self._config, self._keys = config, keys
        self._kept: OrderedDict[int, SubmapMap] = OrderedDict()

    def of(self, submap: Submap) -> SubmapMap:
        """Return the map of a submap, rebuilt if it is not in memory."""
        found = self._kept.pop(submap.number, None) or self._made(submap)
        self._kept[submap.number] = found
        if len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return found

    def _made(self, submap: Submap) -> SubmapMap:
        made = SurfelMap(self._config)
        for number in submap.keys:
            key = self._keys[number]
            made.add(key.facets, key.scan, Pose2D.from_array(key.T_local_laser), walls=False)
        return SubmapMap(made.grid, draw_submap(made.grid, submap.path, REACH))
