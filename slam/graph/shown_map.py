"""Key scan poses in the map of the front end, and the decision when to rebuild that map."""

from typing import Final

import numpy as np

from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.single_poses import composed
from slam.graph.submap_graph import Remaining, SubmapGraph
from slam.pose import FloatArray

MOVED, FAR = 0.02, 0.1
"""Distances in metres that a key scan must have moved for the map to be rebuilt: with many new key scans, and
always."""
NEW_SHARE: Final = 0.03
"""Share of new key scans from which the smaller distance counts."""


class ShownMap:
    """Poses of the key scans in the map of the front end, and the loops that it knows."""

    def __init__(self, graph: SubmapGraph) -> None:
        self._graph = graph
        self._T_map_local = np.zeros(3)
        self._poses: list[FloatArray] = []
        self._rebuilt = 0  # number of key scans when the map was rebuilt
        self._known_loops = 0  # number of known loops

    def add(self, key: KeyScan) -> None:
        """Add a key scan at the front end's pose."""
        self._poses.append(composed(self._T_map_local, key.T_local_laser))

    def has_moved(self) -> bool:
        """Return True if key scans have moved far enough since the last rebuild for another one.

        The smaller distance is enough after many new key scans. Once their number has doubled, the map is rebuilt
        anyway.
        """
        offsets = self._graph.key_poses() - np.array(self._poses)
        moved = float(np.hypot(offsets[:, 0], offsets[:, 1]).max())
        new = self._graph.added_count - self._rebuilt
        return (
            moved > FAR
            or (moved > MOVED and (1.0 + NEW_SHARE) * new >= NEW_SHARE * len(self._poses))
            or new > len(self._poses)
        )

    def renew(self, T_map_local: FloatArray) -> tuple[Loop, ...]:
        """Take over the poses of all key scans in the graph; return the loops that are new to the front end."""
        new = tuple(self._graph.loops[self._known_loops :])
        self._T_map_local, self._known_loops = T_map_local, len(self._graph.loops)
        self._poses, self._rebuilt = list(self._graph.key_poses()), self._graph.added_count
        return new

    def keep(self, left: Remaining) -> None:
        """Remove what has left the graph."""
        self._poses = [self._poses[key] for key in left.keys]
        self._known_loops = sum(loop < self._known_loops for loop in left.loops)
