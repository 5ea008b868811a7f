"""Submaps: stretches of key scans that were matched to one map, and these maps, made again when they are asked for."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from slam.config import SurfelMapConfig
from slam.graph.key_scan import KeyScan
from slam.mapping.surfel_grid import Grid
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D

KEPT: Final = 24
"""Maps of submaps that are kept; others are made again from their key scans."""


@dataclass(slots=True, eq=False)
class Submap:
    """A stretch of key scans, which do not move against each other when the graph of submaps is solved."""

    number: int
    node: int
    T_local_submap: FloatArray
    """(3,): the pose of its first key scan."""
    broken: bool
    """True where odometry alone joins it to the submap before."""
    keys: list[int] = field(default_factory=list)
    """Numbers of its key scans."""


class SubmapGrids:
    """The maps of submaps, each in the frame ``local`` of its key scans."""

    def __init__(self, config: SurfelMapConfig, keys: Sequence[KeyScan]) -> None:
        self._config, self._keys = config, keys
        self._kept: OrderedDict[int, Grid] = OrderedDict()

    def of(self, submap: Submap) -> Grid:
        """The map of a submap to which nothing is added any more."""
        grid = self._kept.pop(submap.number, None) or self._made(submap)
        self._kept[submap.number] = grid
        if len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return grid

    def _made(self, submap: Submap) -> Grid:
        made = SurfelMap(self._config)
        for number in submap.keys:
            key = self._keys[number]
            made.add(key.facets, key.scan, Pose2D.from_array(key.T_local_laser), walls=False)
        return made.grid


def path_of(submap: Submap, keys: Sequence[KeyScan]) -> FloatArray:
    """Poses of the key scans of a submap (K, 3) in its frame ``local``."""
    return np.array([keys[number].T_local_laser for number in submap.keys])
