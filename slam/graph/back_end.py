"""The back end: key scans come in, loops are looked for whenever a submap is finished, and the graph is solved."""

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
from slam.graph.loop import loop_keys
from slam.graph.loop_finder import LoopFinder
from slam.graph.marginals import pose_covariances
from slam.graph.open_loops import settled
from slam.graph.pose_graph import Edges, solve_graph
from slam.graph.pruning import Pruning
from slam.graph.refined_walls import wall_covariances
from slam.graph.single_poses import composed
from slam.graph.submap_graph import SubmapGraph
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray

KERNEL: Final = 30.0
"""chi^2 of a loop's edge, beyond which it loses its weight."""
INDEPENDENT: Final = 0.1
"""Share of what matches say that is not said by their neighbours too: it counts alone where covariances are asked."""
MOVED, FAR = 0.02, 0.1
"""Metres that a key scan must have moved for the map to be made again; beyond the second at once ..."""
NEW_SHARE: Final = 0.03
"""... and up to there when so many key scans, as a share of all, have come since it was made."""


class BackEnd:
    """Finds loops between submaps."""

    def __init__(self, matching: LeastSquaresConfig, config: SurfelMapConfig) -> None:
        self.graph = SubmapGraph()
        self.condensed = CondensedGraph(self.graph, KERNEL)
        self._pruning = Pruning(self.graph, self.condensed)
        self._finder = LoopFinder(self.graph, self.condensed, matching, config)
        self._config = config
        self._T_map_local = np.zeros(3)  # as the front end has it
        self._shown: list[FloatArray] = []  # poses of the key scans in the map that the front end has
        self._rebuilt = 0  # key scans that were taken when that map was made
        self._told = 0  # number of the loops of the closures until now
        self.seconds = 0.0

    def finishes(self, key: KeyScan) -> bool:
        """True for the first key scan that is matched to the next submap."""
        return bool(self.graph.keys) and key.submaps[0] != self.graph.keys[-1].submaps[0]

    @property
    def size(self) -> GraphSize:
        """Counts of what it holds now."""
        graph = self.graph
        counts = len(graph.keys), len(graph.submaps), len(graph.edges), len(graph.loops)
        return GraphSize(*counts, sum(key.nbytes for key in graph.keys), self._finder.tried, self.seconds)

    def take(self, key: KeyScan) -> Closure | None:
        """Take the next key scan; where it finishes a submap, loops are sought for that, and a closure is returned
        where the map has changed."""
        began = thread_time()
        finished = self.graph.keys[-1].submaps[0] if self.finishes(key) else None
        closed = finished is not None and self._finish(finished)
        self.graph.add(key)
        self._shown.append(composed(self._T_map_local, key.T_local_laser))
        closure = self._closure(finished) if finished is not None and closed and self._has_moved() else None
        self.seconds += thread_time() - began
        return closure

    def finish(self, T_base_laser: FloatArray) -> ClosedRun:
        """There are no more key scans: seek loops for the open submaps too, and solve for all nodes."""
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
            loops=tuple(settled(loop, graph) for loop in graph.loops),
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
        loops, self._told = tuple(graph.loops[self._told :]), len(graph.loops)
        poses = self._key_poses()
        self._shown, self._rebuilt = list(poses), graph.taken
        self._T_map_local = graph.correction(last)
        where = loop_keys(graph.loops, {s.number: s.keys for s in graph.submaps.values()}, graph.number_of, poses)
        return Closure(
            submap, self._T_map_local, last.T_local_submap, self.condensed.covariance_of(last), self._map(),
            graph.taken, loops, poses, where,
        )  # fmt: skip

    def _map(self) -> SurfelMap:
        return map_of(zip(self.graph.keys, self._key_poses(), strict=True), SurfelMap(self._config))

    def _key_poses(self) -> FloatArray:
        return np.array([self.graph.poses[node] for node in self.graph.key_nodes]).reshape(-1, 3)

    def _has_moved(self) -> bool:
        """True where key scans have moved so far since they were last shown that the map is worth making again: a
        little is enough where much is new, and nothing where it was written from more than are kept."""
        offsets = self._key_poses() - np.array(self._shown)
        moved = float(np.hypot(offsets[:, 0], offsets[:, 1]).max())
        new = self.graph.taken - self._rebuilt
        return (
            moved > FAR
            or (moved > MOVED and (1.0 + NEW_SHARE) * new >= NEW_SHARE * len(self._shown))
            or new > len(self._shown)
        )

    def _finish(self, number: int) -> bool:
        submap = self.graph.submaps[number]
        if len(submap.keys) < 2:
            return False
        submap.finish(self.graph.keys)
        found = self._finder.find(submap)
        if found:
            self.condensed.solve()
        self._prune(number)
        return found > 0

    def _prune(self, number: int) -> None:
        left = self._pruning.prune(number)
        if left is not None:
            self._shown = [self._shown[key] for key in left.keys]
            self._told = sum(loop < self._told for loop in left.loops)
            self._finder.keep()


def _loop_weights(edges: Edges, weights: FloatArray, loops: int) -> FloatArray:
    """The mean weight (L,) of the edges of every loop."""
    robust = edges.robust
    total = np.bincount(edges.loop[robust], weights[robust], loops)
    return np.asarray(total / np.maximum(np.bincount(edges.loop[robust], minlength=loops), 1))
