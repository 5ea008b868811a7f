"""The back end: key scans come in, loops are looked for whenever a submap is finished, and the graph is solved."""

from time import thread_time
from typing import Final

import numpy as np

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.closed_map import map_of
from slam.graph.closure import ClosedRun, Closure
from slam.graph.condensed import BELIEVED, CondensedGraph
from slam.graph.consistency import WaitingLoops, renumbered
from slam.graph.graph_size import GraphSize
from slam.graph.joint_refinement import refine
from slam.graph.key_scan import KeyScan
from slam.graph.known_graph import KnownGraph
from slam.graph.loop import Loop, loop_keys
from slam.graph.loop_check import distances_to
from slam.graph.loop_search import MOST_WINDOW, LoopSearch
from slam.graph.marginals import pose_covariances
from slam.graph.open_loops import settled
from slam.graph.pose_graph import Edges, solve_graph
from slam.graph.pruning import DELAY, Pruning
from slam.graph.refined_walls import wall_covariances
from slam.graph.single_poses import between, composed
from slam.graph.submap import Submap
from slam.graph.submap_graph import SubmapGraph
from slam.graph.submap_view import SubmapView
from slam.graph.surest_paths import surest_covariances
from slam.graph.wall_candidates import WallCandidate, WallCandidates
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, compose_poses, wrap_angle

KERNEL: Final = 30.0
"""chi^2 of a loop's edge, beyond which it loses its weight."""
MOST_CANDIDATES, ENOUGH = 6, 3
"""Earlier submaps in which a new one is sought at most, and how often it must be found to end the search."""
NEAR: Final = 3.0
"""Metres between two paths ..."""
SIGMAS: Final = 3.0
"""... and so many standard deviations of where they lie, within which a submap is sought."""
GAP_COST: Final = 0.3
"""Standard deviation in metres that counts as much as a metre between the paths when candidates are ordered."""
POOR: Final = 0.9
"""Metres: a way through the graph of this standard deviation leads over a break, and what is found over it ..."""
STANDING_ALONE: Final = 1.2
"""... counts only where another loop bears it out, unless its key scans agree as much as so many whole ones."""
NEIGHBOURS: Final = 2
"""Submaps before a new one that share its walls without a loop."""
THINKABLE: Final = 50.0
"""chi^2 of a place from walls alone by what the graph says, at most."""
BREAK_REACH, BREAK_CANDIDATES = 5.0, 3
"""Where the front end broke: submaps whose path is so near, metres, and how many of them are tried with any heading."""
WALL_SIGMAS: Final = np.array([0.3, 0.3, 0.05])
"""Of a place from walls alone: metres and radians."""
BREAK_SIGMAS: Final = np.array([0.5, 0.5, 2.0])
INDEPENDENT: Final = 0.1
"""Share of what matches say that is not said by their neighbours too: it counts alone where covariances are asked."""
MOVED, FAR = 0.02, 0.1
"""Metres that a key scan must have moved for the map to be made again; beyond the second at once ..."""
NEW_SHARE: Final = 0.03
"""... and up to there when so many key scans, as a share of all, have come since it was made."""


class BackEnd:
    """Finds loops between submaps."""

    def __init__(self, matching: LeastSquaresConfig, config: SurfelMapConfig, known: KnownGraph | None = None) -> None:
        self.graph = SubmapGraph(known)
        self.condensed = CondensedGraph(self.graph, KERNEL)
        self._pruning = Pruning(self.graph, self.condensed)
        self._config, self._search = config, LoopSearch(self.graph, matching, config)
        self._T_map_local = np.zeros(3)  # as the front end has it
        self._shown: list[FloatArray] = []  # poses of the key scans in the map that the front end has
        self._rebuilt = 0  # key scans that were taken when that map was made
        self._told = 0  # number of the loops of the closures until now
        self._finished: list[Submap] = []
        self._walls, self._waiting = WallCandidates(), WaitingLoops(self.graph)
        self.tried, self.seconds = 0, 0.0
        if known is not None:
            self._begin_in_known_graph()

    def finishes(self, key: KeyScan) -> bool:
        """True for the first key scan that is matched to the next submap."""
        return not self.graph.begins_with(key) and key.submaps[0] != self.graph.keys[-1].submaps[0]

    @property
    def size(self) -> GraphSize:
        """Counts of what it holds now."""
        graph = self.graph
        counts = len(graph.keys), len(graph.submaps), len(graph.edges), len(graph.loops)
        return GraphSize(*counts, sum(key.nbytes for key in graph.keys), self.tried, self.seconds)

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

    def _begin_in_known_graph(self) -> None:
        """The submaps of an earlier run are finished, and its map is the one that the front end has."""
        self._shown, self._rebuilt, self._told = list(self._key_poses()), self.graph.taken, len(self.graph.loops)
        for submap in self.graph.submaps.values():
            if len(submap.keys) >= 2:
                self._add_finished(submap)
        self.condensed.solve()
        last = max(self.graph.submaps)
        for number in range(last - 1, last + DELAY + 1):  # those that were too new to be judged when the run ended
            self._prune(number)

    def _add_finished(self, submap: Submap) -> None:
        """From now on it can be found, and others in it."""
        submap.finish(self.graph.keys)
        self._finished.append(submap)
        surfels = SurfelMap(self._config, self._search.map_of(submap).grid).surfels
        self._walls.add(submap, surfels, self._config.cell)

    def _finish(self, number: int) -> bool:
        submap = self.graph.submaps[number]
        if len(submap.keys) < 2:
            return False
        self._add_finished(submap)
        found = self._find_loops(submap)
        if found:
            self.condensed.solve()
        self._prune(number)
        return found > 0

    def _prune(self, number: int) -> None:
        left = self._pruning.prune(number)
        if left is not None:
            self._shown = [self._shown[key] for key in left.keys]
            self._told = sum(loop < self._told for loop in left.loops)
            self._finished = [submap for submap in self._finished if submap.number in self.graph.submaps]
            self._walls.keep(self.graph.submaps)
            self._waiting.forget()

    def _find_loops(self, submap: Submap) -> int:
        """Seek a submap in the earlier ones, the surest first; returns how often it was found."""
        candidates, found, view = self._candidates(submap), 0, self._search.view(submap)
        for other, covariance in candidates[:MOST_CANDIDATES]:
            self.tried += 1
            loop = self._search.find(view, other, covariance, "odometry")
            if loop is not None:
                poor = covariance[0, 0] + covariance[1, 1] > POOR**2
                found += self._add(loop, poor and not _stands_alone(loop))
                if found >= ENOUGH:
                    break
        if submap.broken and not found:
            found += self._find_after_break(view)
        if not found and any(self._is_out_of_reach(submap, other, covariance) for other, covariance in candidates):
            found += self._find_by_walls(view)
        return found

    def _is_out_of_reach(self, submap: Submap, other: Submap, covariance: FloatArray) -> bool:
        """True where the graph says too little of where a submap lies, seen from another, for a search by that."""
        sigma = float(np.sqrt(max(covariance[0, 0], covariance[1, 1])))
        return SIGMAS * sigma > MOST_WINDOW or self._is_break_between(other, submap)

    def _candidates(self, submap: Submap) -> list[tuple[Submap, FloatArray]]:
        """Earlier submaps that may share walls with one, and the covariance of each seen from it, the surest first."""
        covariances = self._covariances_from(submap)
        rows, own = [], self._places(submap)
        for other, distance in zip(self._finished[:-1], self._distances(submap), strict=True):
            covariance = covariances[other.number]
            sigma = float(np.sqrt(covariance[0, 0] + covariance[1, 1]))
            reach = NEAR + SIGMAS * sigma
            if distance - submap.radius - other.radius > reach or self._are_neighbours(other, submap):
                continue
            gap = float(distances_to(own, self._places(other)).min())
            if gap <= reach:
                rows.append((sigma + GAP_COST * gap, other, covariance))
        rows.sort(key=lambda row: row[0])
        return [(other, covariance) for _, other, covariance in rows]

    def _covariances_from(self, submap: Submap) -> dict[int, FloatArray]:
        """Covariance (3, 3) of every submap as seen from one, map axes, by their numbers."""
        submaps = list(self.graph.submaps.values())
        poses = np.array([self.graph.poses[other.node] for other in submaps])
        covariances = surest_covariances(submaps.index(submap), poses, self.condensed.hops())
        return {other.number: covariance for other, covariance in zip(submaps, covariances, strict=True)}

    def _find_after_break(self, view: SubmapView) -> int:
        """Seek a submap with any heading beside where the front end lost its way."""
        submap = view.submap
        own = self._places(submap)
        earlier = [other for other in self._finished[:-1] if other.number < submap.number]
        near = [(float(distances_to(own, self._places(other)).min()), other) for other in earlier]
        near = sorted((row for row in near if row[0] < BREAK_REACH), key=lambda row: row[0])
        for _, other in near[:BREAK_CANDIDATES]:
            self.tried += 1
            loop = self._search.find(view, other, np.diag(BREAK_SIGMAS**2), "break")
            if loop is not None:
                return self._add(loop, not _stands_alone(loop))
        return 0

    def _find_by_walls(self, view: SubmapView) -> int:
        """Seek a submap where its walls alone say that it may be; it counts where another loop bears it out."""
        submap = view.submap
        nearest_first = np.argsort(self._distances(submap), kind="stable").tolist()
        others = [self._finished[at] for at in nearest_first]
        others = [other for other in others if not self._are_neighbours(other, submap)]
        covariance = np.diag(WALL_SIGMAS**2)
        added, covariances = 0, self._covariances_from(submap)
        for candidate in self._walls.of(submap, others):
            if not self._is_thinkable(candidate, submap, covariances[candidate.other.number]):
                continue
            self.tried += 1
            loop = self._search.find_near(view, candidate.other, candidate.T_other_submap, covariance, "walls")
            if loop is not None and not loop.ambiguous:
                added += self._add(loop, doubtful=True)
        return added

    def _is_thinkable(self, candidate: WallCandidate, submap: Submap, covariance: FloatArray) -> bool:
        """True for a place that the graph does not rule out, which has the other with this covariance (3, 3) as seen
        from the submap: a building may look alike from both ends. Over a break it says nothing."""
        other = candidate.other
        if self._is_break_between(other, submap):
            return True
        seen = between(candidate.T_other_submap, other.T_local_submap)
        error = composed(self.graph.correction(submap), seen) - self.graph.poses[other.node]
        error[2] = wrap_angle(float(error[2]))
        return float(error @ np.linalg.solve(covariance, error)) < THINKABLE

    def _add(self, loop: Loop, doubtful: bool) -> int:
        """Add a loop, a doubtful one where another bears it out; returns how many were added."""
        loops = self._waiting.borne_out(loop, self.condensed.hops(), self._believed()) if doubtful else [loop]
        for one in loops:
            self.graph.add_loop(renumbered(one, len(self.graph.loops)))
        return len(loops)

    def _believed(self) -> list[Loop]:
        """Loops that the graph of submaps believes."""
        weighed = zip(self.graph.loops, self.condensed.weights, strict=False)
        return [loop for loop, weight in weighed if weight > BELIEVED]

    def _are_neighbours(self, other: Submap, submap: Submap) -> bool:
        """True where two submaps share key scans, or follow each other without a break."""
        if set(other.keys) & set(submap.keys):
            return True
        low, high = sorted((other.number, submap.number))
        if high - low > NEIGHBOURS:
            return False
        return not self._is_break_between(other, submap)

    def _is_break_between(self, other: Submap, submap: Submap) -> bool:
        low, high = sorted((other.number, submap.number))
        return any(one.broken for number, one in self.graph.submaps.items() if low < number <= high)

    def _distances(self, submap: Submap) -> FloatArray:
        """Metres from the middle of a submap to those of all that were finished before the last, (F,)."""
        corrections = np.array([self.graph.correction(other) for other in self._finished[:-1]]).reshape(-1, 3)
        local = np.array([[*other.middle, 0.0] for other in self._finished[:-1]]).reshape(-1, 3)
        middles = compose_poses(corrections, local)
        own = composed(self.graph.correction(submap), np.append(submap.middle, 0.0))
        return np.asarray(np.hypot(*(middles - own)[:, :2].T))

    def _places(self, submap: Submap) -> FloatArray:
        """Poses (K, 3) of the key scans of a finished submap, as the graph has them."""
        return compose_poses(self.graph.correction(submap), submap.path)


def _stands_alone(loop: Loop) -> bool:
    return loop.share * loop.tested >= STANDING_ALONE


def _loop_weights(edges: Edges, weights: FloatArray, loops: int) -> FloatArray:
    """The mean weight (L,) of the edges of every loop."""
    robust = edges.robust
    total = np.bincount(edges.loop[robust], weights[robust], loops)
    return np.asarray(total / np.maximum(np.bincount(edges.loop[robust], minlength=loops), 1))
