"""The back end: key scans come in, loops are looked for whenever a submap is finished, and the graph is solved."""

from typing import Final

import numpy as np

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.condensed import CondensedGraph
from slam.graph.key_scan import KeyScan
from slam.graph.loop_search import LoopSearch
from slam.graph.pose_graph import Edges, solve_graph
from slam.graph.submap import Submap, path_of
from slam.graph.submap_graph import SubmapGraph
from slam.graph.surest_paths import surest_covariances
from slam.pose import FloatArray, compose_poses

KERNEL: Final = 30.0
"""chi^2 of a loop's edge, beyond which it loses its weight."""
MOST_CANDIDATES, ENOUGH = 10, 4
"""Earlier submaps in which a new one is sought at most, and how often it must be found to end the search."""
NEAR: Final = 3.0
"""Metres between two paths ..."""
SIGMAS: Final = 3.0
"""... and so many standard deviations of where they lie, within which a submap is sought."""
GAP_COST: Final = 0.3
"""Standard deviation in metres that counts as much as a metre between the paths when candidates are ordered."""
NEIGHBOURS: Final = 2
"""Submaps before a new one that share its walls without a loop."""
BREAK_REACH, BREAK_CANDIDATES = 5.0, 3
"""Where the front end broke: submaps whose path is so near, metres, and how many of them are tried with any heading."""
BREAK_SIGMAS: Final = np.array([0.5, 0.5, 2.0])


class BackEnd:
    """Finds loops between submaps."""

    def __init__(self, matching: LeastSquaresConfig, config: SurfelMapConfig) -> None:
        self.graph = SubmapGraph()
        self.condensed = CondensedGraph(self.graph, KERNEL)
        self._search = LoopSearch(self.graph, matching, config)
        self._finished: list[Submap] = []
        self.tried = 0

    def take(self, key: KeyScan) -> bool:
        """Take the next key scan; True where a loop was closed, so that poses have changed."""
        before = self.graph.keys[-1].submaps[0] if self.graph.keys else key.submaps[0]
        closed = self._finish(before) if key.submaps[0] != before else False
        self.graph.add(key)
        return closed

    def end(self) -> bool:
        """There are no more key scans: the open submaps are finished too."""
        closed = False
        if self.graph.keys:
            for number in self.graph.keys[-1].submaps:
                closed = self._finish(number) or closed
        return closed

    def solve(self) -> FloatArray:
        """Solve the whole graph; the weights (E,) of its edges."""
        graph = self.graph
        solution = solve_graph(np.array(graph.poses), Edges.of(graph.edges), KERNEL)
        graph.poses = list(solution.poses)
        return solution.weights

    def _finish(self, number: int) -> bool:
        submap = self.graph.submaps[number]
        if len(submap.keys) < 2:
            return False
        self._finished.append(submap)
        found = self._find_loops(submap)
        if found:
            self.condensed.solve()
        return found > 0

    def _find_loops(self, submap: Submap) -> int:
        """Seek a submap in the earlier ones, the surest first; returns how often it was found."""
        candidates, found = self._candidates(submap), 0
        for other, covariance in candidates[:MOST_CANDIDATES]:
            self.tried += 1
            loop = self._search.find(submap, other, covariance, "odometry")
            if loop is not None:
                self.graph.add_loop(loop)
                found += 1
                if found == ENOUGH:
                    break
        if submap.broken and not found:
            found += self._find_after_break(submap)
        return found

    def _candidates(self, submap: Submap) -> list[tuple[Submap, FloatArray]]:
        """Earlier submaps that may share walls with one, and the covariance of each seen from it, the surest first."""
        at = {other.number: k for k, other in enumerate(self.graph.submaps.values())}
        poses = np.array([self.graph.poses[other.node] for other in self.graph.submaps.values()])
        covariances = surest_covariances(at[submap.number], poses, self.condensed.hops())
        rows = []
        for other in self._finished[:-1]:
            if self._are_neighbours(other, submap):
                continue
            covariance = covariances[at[other.number]]
            sigma = float(np.sqrt(covariance[0, 0] + covariance[1, 1]))
            gap = self._gap(submap, other)
            if gap <= NEAR + SIGMAS * sigma:
                rows.append((sigma + GAP_COST * gap, other, covariance))
        rows.sort(key=lambda row: row[0])
        return [(other, covariance) for _, other, covariance in rows]

    def _find_after_break(self, submap: Submap) -> int:
        """Seek a submap with any heading beside where the front end lost its way."""
        near = [(self._gap(submap, other), other) for other in self._finished[:-1] if other.number < submap.number]
        near = sorted((row for row in near if row[0] < BREAK_REACH), key=lambda row: row[0])
        for _, other in near[:BREAK_CANDIDATES]:
            self.tried += 1
            loop = self._search.find(submap, other, np.diag(BREAK_SIGMAS**2), "break")
            if loop is not None:
                self.graph.add_loop(loop)
                return 1
        return 0

    def _are_neighbours(self, other: Submap, submap: Submap) -> bool:
        """True where two submaps share key scans, or follow each other without a break."""
        if set(other.keys) & set(submap.keys):
            return True
        low, high = sorted((other.number, submap.number))
        if high - low > NEIGHBOURS:
            return False
        return not any(self.graph.submaps[number].broken for number in range(low + 1, high + 1))

    def _gap(self, submap: Submap, other: Submap) -> float:
        """Metres between the paths of two submaps, as the graph has them."""
        graph = self.graph
        own, others = (
            compose_poses(graph.correction(each), path_of(each, graph.keys))[:, :2] for each in (submap, other)
        )
        offsets = own[:, None] - others[None]
        return float(np.hypot(offsets[..., 0], offsets[..., 1]).min())
