"""The graph of submaps alone: small enough to be solved whenever a loop was found."""

from typing import Final

import numpy as np

from slam.graph.loop import Loop
from slam.graph.marginals import pose_covariances
from slam.graph.pose_graph import BREAK, NO_LOOP, Edge, Edges, solve_graph
from slam.graph.single_poses import between, composed
from slam.graph.submap import Submap
from slam.graph.submap_graph import SubmapGraph
from slam.graph.surest_paths import Hops
from slam.pose import FloatArray, wrap_angle

HOP_SIGMAS: Final = np.array([0.08, 0.08, 0.04])
"""From one submap to the next, for the search of candidates: metres and radians. The graph takes half of it."""
BREAK_SIGMAS: Final = np.array([0.7, 0.7, 0.6])
"""Beyond that, where the front end broke."""
BREAK_WEIGHT: Final = 0.05
"""Of an edge over a break, in the graph."""
LOOP_SIGMAS: Final = np.array([0.1, 0.1, 0.01])
"""Over a loop, for the search of candidates ..."""
CONDENSED_SIGMAS: Final = np.array([0.03, 0.03, 0.005])
"""... and in the graph, beyond those of its matches."""
BELIEVED: Final = 0.3
"""Weight of a loop, from which on candidates are sought over it."""
TOLERANCE: Final = 1e-3
"""Metres and radians."""


class CondensedGraph:
    """Submaps, each with the key scans riding on it, and one edge for each loop."""

    def __init__(self, graph: SubmapGraph, kernel: float) -> None:
        self._graph, self._kernel = graph, kernel
        self._edges: list[Edge] = []  # of the loops, between numbers of submaps
        self._covariances: dict[int, FloatArray] = {}
        self.weights = np.empty(0)
        """Weight of every loop."""

    def solve(self) -> None:
        """Solve for the submaps; the key scans follow."""
        graph, submaps = self._graph, self._submaps
        for loop in graph.loops[len(self._edges) :]:
            self._edges.append(_condensed(loop, graph))
        at = {submap.number: k for k, submap in enumerate(submaps)}
        chain = [_hop_edge(k, submaps[k], submaps[k + 1]) for k in range(len(submaps) - 1)]
        loops = [edge._replace(first=at[edge.first], second=at[edge.second]) for edge in self._edges]
        poses = np.array([graph.poses[submap.node] for submap in submaps])
        edges = Edges.of([*chain, *loops])
        solution = solve_graph(poses, edges, self._kernel, TOLERANCE)
        for submap, pose in zip(submaps, solution.poses, strict=True):
            graph.poses[submap.node] = pose
        self.weights = solution.weights[len(chain) :]
        graph.place_keys()
        covariances = pose_covariances(solution.poses, edges, solution.weights)
        self._covariances = {submap.number: C for submap, C in zip(submaps, covariances, strict=True)}

    def covariance_of(self, submap: Submap) -> FloatArray:
        """Covariance (3, 3) of the place of a submap, map frame, as it was when the graph was solved last."""
        return self._covariances.get(submap.number, next(reversed(self._covariances.values())))

    def hops(self) -> Hops:
        """Steps between submaps, over which candidates are sought."""
        submaps = self._submaps
        at = {submap.number: k for k, submap in enumerate(submaps)}
        first, second = list(range(len(submaps) - 1)), list(range(1, len(submaps)))
        broken = [np.diag(BREAK_SIGMAS**2) if submap.broken else 0.0 for submap in submaps[1:]]
        covariance = [np.diag(HOP_SIGMAS**2) + more for more in broken]
        for loop, weight in zip(self._graph.loops, self.weights, strict=False):
            if weight > BELIEVED:
                first.append(at[loop.other])
                second.append(at[loop.submap])
                covariance.append(np.diag(LOOP_SIGMAS**2))
        return Hops(np.array(first, np.int64), np.array(second, np.int64), np.array(covariance).reshape(-1, 3, 3))

    @property
    def _submaps(self) -> list[Submap]:
        return list(self._graph.submaps.values())


def _hop_edge(k: int, submap: Submap, following: Submap) -> Edge:
    information = np.diag(4.0 / HOP_SIGMAS**2) * (BREAK_WEIGHT if following.broken else 1.0)
    measured = between(submap.T_local_submap, following.T_local_submap)
    return Edge(k, k + 1, measured, information, BREAK if following.broken else NO_LOOP)


def _condensed(loop: Loop, graph: SubmapGraph) -> Edge:
    """One edge for all of a loop: where the submap lies in the other, by its key scans together."""
    submap, other = graph.submaps[loop.submap], graph.submaps[loop.other]
    measured = between(other.T_local_submap, composed(loop.T_other_submap, submap.T_local_submap))
    H, g = np.zeros((3, 3)), np.zeros(3)
    for edge in loop.edges:
        key = graph.keys[graph.number_of(edge.second)]
        own = between(submap.T_local_submap, key.T_local_laser)
        error = edge.measured - composed(measured, own)
        error[2] = wrap_angle(float(error[2]))
        J = _lever(measured, own)
        H += J.T @ edge.information @ J
        g += J.T @ edge.information @ error
    H += 1e-6 * np.eye(3)
    measured = measured + np.linalg.solve(H, g)
    information = np.linalg.inv(np.linalg.inv(H) + np.diag(CONDENSED_SIGMAS**2))
    return Edge(loop.other, loop.submap, measured, information, loop.number)


def _lever(measured: FloatArray, own: FloatArray) -> FloatArray:
    """Derivative (3, 3) of measured @ own by ``measured``."""
    offset = composed(measured, own)[:2] - measured[:2]
    return np.array([[1.0, 0.0, -offset[1]], [0.0, 1.0, offset[0]], [0.0, 0.0, 1.0]])
