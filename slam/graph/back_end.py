"""The back end: it takes key scans, searches loops whenever a submap is finished, and solves the graph."""

from time import thread_time
from typing import Final

import numpy as np

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.closed_map import map_of
from slam.graph.closure import ClosedRun, Closure
from slam.graph.condensed import CondensedGraph
from slam.graph.graph_size import GraphSize
from slam.graph.joint_refinement import refine
from slam.graph.key_scan import KeyScan
from slam.graph.known_graph import KnownGraph
from slam.graph.loop import loop_keys
from slam.graph.loop_finder import LoopFinder
from slam.graph.marginals import pose_covariances
from slam.graph.open_loops import completed_by_graph
from slam.graph.pose_graph import Edges, solve_graph
from slam.graph.pruning import DELAY, Pruning
from slam.graph.refined_walls import wall_covariances
from slam.graph.shown_map import ShownMap
from slam.graph.submap_graph import SubmapGraph
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray

KERNEL: Final = 30.0
"""chi^2 of a loop's edge at which its weight is a quarter."""
INDEPENDENT: Final = 0.1
"""Share of a match's information that is independent of its neighbours; only that is used for covariances."""


class BackEnd:
    """Finds loops between submaps."""

    def __init__(self, matching: LeastSquaresConfig, config: SurfelMapConfig, known: KnownGraph | None = None) -> None:
        self.graph = SubmapGraph(known)
        self.condensed = CondensedGraph(self.graph, KERNEL)
        self._pruning = Pruning(self.graph, self.condensed)
        self._finder = LoopFinder(self.graph, self.condensed, matching, config)
        self._config = config
        self._shown = ShownMap(self.graph)
        self.seconds = 0.0
        if known is not None:
            self._begin_in_known_graph()

    def finishes(self, key: KeyScan) -> bool:
        """True for the first key scan that is matched to the next submap."""
        return not self.graph.is_first_of_run(key) and key.submaps[0] != self.graph.keys[-1].submaps[0]

    @property
    def size(self) -> GraphSize:
        """Present counts of the graph."""
        graph = self.graph
        counts = len(graph.keys), len(graph.submaps), len(graph.edges), len(graph.loops)
        return GraphSize(*counts, sum(key.nbytes for key in graph.keys), self._finder.tried, self.seconds)

    def take(self, key: KeyScan) -> Closure | None:
        """Take the next key scan.

        If it finishes a submap, loops are searched for that submap, and a closure is returned if the map has changed.
        """
        began = thread_time()
        finished = self.graph.keys[-1].submaps[0] if self.finishes(key) else None
        closed = finished is not None and self._finish(finished)
        self.graph.add(key)
        self._shown.add(key)
        closure = self._closure(finished) if finished is not None and closed and self._shown.has_moved() else None
        self.seconds += thread_time() - began
        return closure

    def finish(self, T_base_laser: FloatArray) -> ClosedRun:
        """Finish after the last key scan: search loops for the open submaps too, and solve for all nodes."""
        graph = self.graph
        began = thread_time()
        for number in graph.keys[-1].submaps if graph.keys else ():
            self._finish(number)
        ties, odometry = graph.tie_edges(), graph.odometry_edges()
        edges = Edges.of([*graph.edges, *ties, *odometry])
        is_odometry = np.arange(len(edges.loop)) >= len(graph.edges) + len(ties)
        solution = solve_graph(np.array(graph.poses).reshape(-1, 3), edges, KERNEL)
        edges, weights = edges.settled(solution.weights)
        key_nodes = np.array(graph.key_nodes, np.int64)
        facets = [key.facets for key in graph.keys]
        nodes, walls, _ = refine(solution.poses, edges, weights, facets, key_nodes)
        graph.poses = list(nodes)
        covariances = pose_covariances(nodes, edges, weights * np.where(is_odometry, 1.0, INDEPENDENT))
        surfel_map = self._map()
        self.seconds += thread_time() - began
        return ClosedRun(
            keys=tuple(graph.keys),
            poses=nodes[key_nodes],
            covariances=covariances[key_nodes],
            map=surfel_map,
            loops=tuple(completed_by_graph(loop, graph) for loop in graph.loops),
            weights=_loop_weights(edges, weights, len(graph.loops)),
            nodes=nodes,
            key_nodes=key_nodes,
            submaps=tuple(graph.submaps.values()),
            edges=edges,
            edge_weights=weights,
            T_base_laser=T_base_laser,
            walls=walls,
            wall_covariances=wall_covariances(walls, nodes, covariances),
            size=self.size,
            anchors=self._pruning.anchors.placed({s.number: nodes[s.node] for s in graph.submaps.values()}),
        )

    def _closure(self, submap: int) -> Closure:
        graph = self.graph
        last = graph.submaps[graph.keys[-1].submaps[0]]
        T_map_local, poses = graph.correction(last), graph.key_poses()
        loops = self._shown.renew(T_map_local)
        where = loop_keys(graph.loops, {s.number: s.keys for s in graph.submaps.values()}, graph.number_of, poses)
        return Closure(
            submap, T_map_local, last.T_local_submap, self.condensed.covariance_of(last), self._map(),
            graph.added_count, loops, poses, np.array([key.index for key in graph.keys], np.int64), where,
        )  # fmt: skip

    def _map(self) -> SurfelMap:
        return map_of(zip(self.graph.keys, self.graph.key_poses(), strict=True), SurfelMap(self._config))

    def _begin_in_known_graph(self) -> None:
        """Begin with the submaps of an earlier run, which are finished; the front end already has their map."""
        self._shown.renew(np.zeros(3))
        for submap in self.graph.submaps.values():
            if len(submap.keys) >= 2:
                self._finder.add(submap)
        self.condensed.solve()
        last = max(self.graph.submaps)
        for number in range(last - 1, last + DELAY + 1):  # too new to be judged when that run ended
            self._prune(number)

    def _finish(self, number: int) -> bool:
        submap = self.graph.submaps[number]
        if len(submap.keys) < 2:
            return False
        submap.finish(self.graph.keys)
        self._finder.add(submap)
        found = self._finder.find(submap)
        if found:
            self.condensed.solve()
        self._prune(number)
        return found > 0

    def _prune(self, number: int) -> None:
        left = self._pruning.prune(number)
        if left is not None:
            self._shown.keep(left)
            self._finder.keep()


def _loop_weights(edges: Edges, weights: FloatArray, loops: int) -> FloatArray:
    """Return the mean weight (L,) of the edges of every loop."""
    robust = edges.robust
    total = np.bincount(edges.loop[robust], weights[robust], loops)
    return np.asarray(total / np.maximum(np.bincount(edges.loop[robust], minlength=loops), 1))
