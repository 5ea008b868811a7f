"""The graph of a run at its last solution, in the form that is saved beside the map."""

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
"""Weight above which a loop is accepted."""


@dataclass(frozen=True, eq=False)
class RunGraph:
    """Nodes, edges and loops; poses are of the laser, map frame."""

    T_base_laser: FloatArray
    """(3,): mount of the laser."""
    nodes: FloatArray
    """(N, 3): poses of all nodes; the first is fixed."""
    key_nodes: IntArray
    """(K,): node of each key scan."""
    scans: IntArray
    """(K,): index of its scan in the run, below zero for an earlier run."""
    key_submaps: tuple[tuple[int, ...], ...]
    """Numbers of the submaps to which each key scan was added. It was matched to the first of them."""
    covariances: FloatArray
    """(K, 3, 3): covariance of its pose."""
    submaps: tuple[Submap, ...]
    edges: Edges
    edge_weights: FloatArray
    """(E,): weight of each edge; 1 for those of no loop."""
    loops: tuple[Loop, ...]
    weights: FloatArray
    """(L,): weight of each loop, 0 to 1."""

    @classmethod
    def of(cls, closed: ClosedRun) -> Self:
        """Return the graph of a finished run."""
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
        """Mask of the accepted loops, (L,)."""
        return np.asarray(self.weights > BELIEVED)

    @property
    def chi_squared(self) -> FloatArray:
        """Chi^2 of every edge (E,), unweighted."""
        return squared_errors(self.nodes, self.edges)

    @cached_property
    def loop_scans(self) -> IntArray:
        """Scan indices of each loop, (L, 2): where a place was seen again, and where it was seen before."""
        return np.asarray(self.scans[self._loop_keys])

    def loop_ends(self, poses: FloatArray) -> FloatArray:
        """Return the two positions of each loop (L, 2, 2) by the poses of the base (S, 3) at the scans of the run.

        For scans of an earlier run, and scans whose poses were lost by damage, the positions in the graph are used.
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
