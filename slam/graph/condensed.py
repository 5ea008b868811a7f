"""The graph of submaps alone: small enough to be solved after every loop."""

from itertools import pairwise
from typing import Final

import numpy as np

from slam.graph.joined_edges import lever
from slam.graph.loop import Loop
from slam.graph.marginals import pose_covariances
from slam.graph.pose_graph import BREAK, NO_LOOP, Edge, Edges, solve_graph
from slam.graph.single_poses import between, composed
from slam.graph.submap import Submap
from slam.graph.submap_graph import SubmapGraph
from slam.graph.surest_paths import SubmapSteps
from slam.pose import FloatArray, wrap_angle

STEP_SIGMAS: Final = np.array([0.08, 0.08, 0.04])
"""Standard deviations from one submap to the next in the search of loop candidates, metres and radians. The graph uses
half of them."""
BREAK_SIGMAS: Final = np.array([0.7, 0.7, 0.6])
"""Standard deviations that a break of the front end between two submaps adds, metres and radians."""
BREAK_WEIGHT: Final = 0.05
"""Weight of an edge over a break, in the graph."""
LOOP_SIGMAS: Final = np.array([0.1, 0.1, 0.01])
"""Standard deviations over a loop in the search of loop candidates, metres and radians."""
CONDENSED_SIGMAS: Final = np.array([0.03, 0.03, 0.005])
"""Standard deviations over a loop in the graph, in addition to those of its matches."""
BELIEVED: Final = 0.3
"""Weight above which a loop, or the tie to an earlier run, is taken as correct."""
TOLERANCE: Final = 1e-3
"""The solver stops at a step below this, metres and radians."""


class CondensedGraph:
    """Graph of the submaps, each with its key scans attached, and one edge for each loop."""

    def __init__(self, graph: SubmapGraph, kernel: float) -> None:
        self._graph, self._kernel = graph, kernel
        self._edges: list[Edge] = []  # one for each loop; its ends are numbers of submaps
        self._covariances: dict[int, FloatArray] = {}
        self.weights = np.empty(0)
        """Weight of every loop."""

    def solve(self) -> None:
        """Solve for the poses of the submaps; the key scans follow."""
        graph, submaps = self._graph, self._submaps
        for loop in graph.loops[len(self._edges) :]:
            self._edges.append(_condensed(loop, graph))
        at = {submap.number: k for k, submap in enumerate(submaps)}
        chain = self.chain()
        edges = [edge._replace(first=at[edge.first], second=at[edge.second]) for edge in [*chain, *self._edges]]
        poses = np.array([graph.poses[submap.node] for submap in submaps])
        stacked = Edges.of(edges)
        solution = solve_graph(poses, stacked, self._kernel, TOLERANCE)
        for submap, pose in zip(submaps, solution.poses, strict=True):
            graph.poses[submap.node] = pose
        self.weights = solution.weights[len(chain) :]
        self._trust_start(solution.weights[len(chain) - len(graph.ties) : len(chain)])
        graph.place_keys()
        covariances = pose_covariances(solution.poses, stacked, solution.weights)
        self._covariances = {submap.number: C for submap, C in zip(submaps, covariances, strict=True)}

    def covariance_of(self, submap: Submap) -> FloatArray:
        """Return the covariance (3, 3) of the pose of a submap, map frame, at the last solution."""
        return self._covariances.get(submap.number, next(reversed(self._covariances.values())))

    def steps(self) -> SubmapSteps:
        """Return the steps between submaps over which loop candidates are searched."""
        submaps = self._submaps
        at = {submap.number: k for k, submap in enumerate(submaps)}
        steps = [(k - 1, k) for k in range(1, len(submaps)) if _follows(submaps[k - 1], submaps[k])]
        covariance = [np.diag(STEP_SIGMAS**2 + BREAK_SIGMAS**2 * submaps[k].broken) for _, k in steps]
        for pair in self._graph.ties:
            steps.append((at[pair[0]], at[pair[1]]))
            covariance.append(np.diag(STEP_SIGMAS**2 + LOOP_SIGMAS**2))
        for loop, weight in zip(self._graph.loops, self.weights, strict=False):
            if weight > BELIEVED:
                steps.append((at[loop.other], at[loop.submap]))
                covariance.append(np.diag(LOOP_SIGMAS**2))
        first, second = np.array(steps, np.int64).reshape(-1, 2).T
        return SubmapSteps(first, second, np.array(covariance).reshape(-1, 3, 3))

    def chain(self) -> list[Edge]:
        """Return all edges except loops: from each submap to the next, and the ties; ends are numbers of submaps."""
        submaps = self._submaps
        steps = [_step_edge(*pair) for pair in pairwise(submaps) if _follows(*pair)]
        return [*steps, *self._graph.ties.values()]

    def edges_of(self, number: int) -> list[Edge]:
        """Return the edges of a submap; their ends are numbers of submaps.

        The information of a loop is multiplied by its weight.
        """
        loops = zip(self._edges, self.weights.tolist(), strict=True)
        weighed = [edge._replace(information=weight * edge.information) for edge, weight in loops if weight > BELIEVED]
        return [edge for edge in [*self.chain(), *weighed] if number in (edge.first, edge.second)]

    def keep_loops(self, kept: list[int]) -> None:
        """Keep only these loops, and number them in this order."""
        self._edges = [self._edges[old]._replace(loop=new) for new, old in enumerate(kept)]
        self.weights = self.weights[kept]

    def _trust_start(self, weights: FloatArray) -> None:
        """Replace the tie to an earlier run by the loops that confirm it, with full weight.

        Otherwise a distorted old map would rather reject the new part than be corrected. ``weights`` are those of the
        ties.
        """
        graph = self._graph
        for (pair, tie), weight in zip(list(graph.ties.items()), weights.tolist(), strict=True):
            found = self._sure_edges_of(tie.second) if tie.loop == BREAK and weight > BELIEVED else []
            if found:
                del graph.ties[pair]
            for edge in found:
                graph.ties[edge.first, edge.second] = edge._replace(loop=NO_LOOP)

    def _sure_edges_of(self, submap: int) -> list[Edge]:
        weighed = zip(self._graph.loops, self._edges, self.weights.tolist(), strict=True)
        return [e for loop, e, weight in weighed if loop.submap == submap and weight > BELIEVED and not loop.ambiguous]

    @property
    def _submaps(self) -> list[Submap]:
        return list(self._graph.submaps.values())


def _follows(submap: Submap, following: Submap) -> bool:
    """Return False if submaps between the two were removed."""
    return following.number == submap.number + 1


def _step_edge(submap: Submap, following: Submap) -> Edge:
    information = np.diag(4.0 / STEP_SIGMAS**2) * (BREAK_WEIGHT if following.broken else 1.0)
    measured = between(submap.T_local_submap, following.T_local_submap)
    return Edge(submap.number, following.number, measured, information, BREAK if following.broken else NO_LOOP)


def _condensed(loop: Loop, graph: SubmapGraph) -> Edge:
    """Return one edge for a loop: the pose of one submap in the other, from the edges of all agreeing key scans."""
    submap, other = graph.submaps[loop.submap], graph.submaps[loop.other]
    measured = between(other.T_local_submap, composed(loop.T_other_submap, submap.T_local_submap))
    H, g = np.zeros((3, 3)), np.zeros(3)
    for edge in loop.edges:
        key = graph.keys[graph.number_of(edge.second)]
        own = between(submap.T_local_submap, key.T_local_laser)
        error = edge.measured - composed(measured, own)
        error[2] = wrap_angle(float(error[2]))
        J = lever(measured, own)
        H += J.T @ edge.information @ J
        g += J.T @ edge.information @ error
    H += 1e-6 * np.eye(3)
    measured = measured + np.linalg.solve(H, g)
    information = np.linalg.inv(np.linalg.inv(H) + np.diag(CONDENSED_SIGMAS**2))
    return Edge(loop.other, loop.submap, measured, information, loop.number)
