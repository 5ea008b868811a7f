"""The map that the front end has: where its key scans lie in it, and when it is worth making again."""

from typing import Final

import numpy as np

from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.single_poses import composed
from slam.graph.submap_graph import Left, SubmapGraph
from slam.pose import FloatArray

MOVED, FAR = 0.02, 0.1
"""Metres that a key scan must have moved for the map to be made again; beyond the second at once ..."""
NEW_SHARE: Final = 0.03
"""... and up to there when so many key scans, as a share of all, have come since it was made."""


class ShownMap:
    """Poses of the key scans as the front end has them, and the loops that it was told of."""

    def __init__(self, graph: SubmapGraph) -> None:
        self._graph = graph
        self._T_map_local = np.zeros(3)
        self._poses: list[FloatArray] = []
        self._rebuilt = 0  # key scans that were taken when the map was made
        self._told = 0  # number of loops

    def add(self, key: KeyScan) -> None:
        """Put a key scan where the front end has put it."""
        self._poses.append(composed(self._T_map_local, key.T_local_laser))

    def has_moved(self) -> bool:
        """True where key scans have moved so far since they were last shown that the map is worth making again.

        A little is enough where much is new, and nothing where it was written from more than are kept.
        """
        offsets = self._graph.key_poses() - np.array(self._poses)
        moved = float(np.hypot(offsets[:, 0], offsets[:, 1]).max())
        new = self._graph.taken - self._rebuilt
        return (
            moved > FAR
            or (moved > MOVED and (1.0 + NEW_SHARE) * new >= NEW_SHARE * len(self._poses))
            or new > len(self._poses)
        )

    def renew(self, T_map_local: FloatArray) -> tuple[Loop, ...]:
        """The front end gets all key scans as the graph has them now; returns the loops that are new to it."""
        new = tuple(self._graph.loops[self._told :])
        self._T_map_local, self._told = T_map_local, len(self._graph.loops)
        self._poses, self._rebuilt = list(self._graph.key_poses()), self._graph.taken
        return new

    def keep(self, left: Left) -> None:
        """Forget what has left the graph."""
        self._poses = [self._poses[key] for key in left.keys]
        self._told = sum(loop < self._told for loop in left.loops)
