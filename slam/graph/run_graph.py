"""The graph of a run as it was solved last: what is kept of it beside the map, and what is known of its loops."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from slam.graph.closure import ClosedRun
from slam.graph.loop import Loop, loop_keys
from slam.graph.pose_graph import Edges, squared_errors
from slam.graph.submap import Submap
from slam.lines.segments import IntArray
from slam.pose import FloatArray, compose_poses, inverse_poses

BELIEVED: Final = 0.5
"""Weight above which a loop is believed."""


@dataclass(frozen=True, eq=False)
class RunGraph:
    """Nodes, what is known between them, and the loops; poses are of the laser, map frame."""

    T_base_laser: FloatArray
    """(3,)."""
    nodes: FloatArray
    """(N, 3): the poses of all nodes; the first stays where it is."""
    key_nodes: IntArray
    """(K,): the node of each key scan, ..."""
    scans: IntArray
    """... the number of its scan in the run (K,), below zero where it is one of an earlier run, ..."""
    key_submaps: tuple[tuple[int, ...], ...]
    """... the numbers of the submaps that it was written into, the one that it was matched to first, ..."""
    covariances: FloatArray
    """... and the covariance (K, 3, 3) of its pose."""
    submaps: tuple[Submap, ...]
    edges: Edges
    edge_weights: FloatArray
    """(E,): 1, or how far an edge of a loop is believed."""
    loops: tuple[Loop, ...]
    weights: FloatArray
    """(L,): how far each loop is believed, 0 to 1."""

    @classmethod
    def of(cls, closed: ClosedRun) -> Self:
        """The graph of a run that is over."""
        return cls(
            closed.T_base_laser, closed.nodes, closed.key_nodes, closed.indices,
            tuple(key.submaps for key in closed.keys), closed.covariances, closed.submaps, closed.edges,
            closed.edge_weights, closed.loops, closed.weights,
        )  # fmt: skip

    @property
    def poses(self) -> FloatArray:
        """``T_map_laser`` of the key scans, (K, 3)."""
        return np.asarray(self.nodes[self.key_nodes])

    @property
    def believed(self) -> NDArray[np.bool_]:
        """True for the loops that are believed, (L,)."""
        return np.asarray(self.weights > BELIEVED)

    @property
    def chi_squared(self) -> FloatArray:
        """chi^2 of every edge (E,), not weighed."""
        return squared_errors(self.nodes, self.edges)

    @cached_property
    def loop_scans(self) -> IntArray:
        """Numbers of two scans of each loop, (L, 2): where a place was seen again, and where it was seen before."""
        return np.asarray(self.scans[self._loop_keys])

    def loop_ends(self, poses: FloatArray) -> FloatArray:
        """The two places of each loop (L, 2, 2) by the poses of the base (S, 3) with the scans of the run.

        For scans of an earlier run or behind a damaged line they are as the graph has them.
        """
        known = compose_poses(self.poses, inverse_poses(self.T_base_laser)[None].repeat(len(self.poses), axis=0))
        own = (self.scans >= 0) & (self.scans < len(poses))
        known[own] = poses[self.scans[own]]
        return np.asarray(known[self._loop_keys][..., :2])

    @cached_property
    def _loop_keys(self) -> IntArray:
        keys_of = {submap.number: submap.keys for submap in self.submaps}
        key_at = {node: number for number, node in enumerate(self.key_nodes.tolist())}
        return loop_keys(self.loops, keys_of, key_at.__getitem__, self.poses)
