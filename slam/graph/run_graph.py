"""The graph of a run as it was solved last: what is kept of it beside the map, and what is known of its loops."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from slam.graph.closure import ClosedRun
from slam.graph.loop import Loop
from slam.graph.pose_graph import Edges, squared_errors
from slam.graph.submap import Submap
from slam.lines.segments import IntArray
from slam.pose import FloatArray, Pose2D

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
    """... the number of its scan in the run (K,), ..."""
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
        """Where each loop lies in the run, (L, 2): the number of a scan of the submap that was found, the middle one of
        those that agree, and that of the nearest key scan of the submap in which it was found."""
        keys_of = {submap.number: np.array(submap.keys) for submap in self.submaps}
        key_at = {node: number for number, node in enumerate(self.key_nodes.tolist())}
        pairs = []
        for loop in self.loops:
            own = key_at[loop.edges[len(loop.edges) // 2].second]
            others = keys_of[loop.other]
            distances = np.hypot(*(self.poses[others] - self.poses[own])[:, :2].T)
            pairs.append((self.scans[own], self.scans[others[np.argmin(distances)]]))
        return np.array(pairs, np.int64).reshape(-1, 2)


def loop_text(loop: Loop) -> str:
    """What was found, as in: submap 41 found in submap 3, 14 of 15 scans agree."""
    open_side = ", one direction left open" if loop.ambiguous else ""
    agree = f"{loop.agreeing} of {loop.tested} scans agree"
    return f"submap {loop.submap} found in submap {loop.other}, {agree}{open_side}"


def pose_moved(before: Pose2D, after: Pose2D) -> str:
    """How far a closure moved the robot, as in: 0.42 m, 1.2 deg."""
    return f"{before.distance(after):.2f} m, {abs(np.degrees(before.between(after).theta)):.1f} deg"
