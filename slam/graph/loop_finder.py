"""Finds the loops of one submap after the other: it searches candidates, and adds results to the graph."""

from typing import Final

import numpy as np

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.condensed import BELIEVED, CondensedGraph
from slam.graph.consistency import WaitingLoops, renumbered
from slam.graph.loop import Loop
from slam.graph.loop_candidates import LoopCandidates
from slam.graph.loop_search import LoopSearch
from slam.graph.submap import Submap
from slam.graph.submap_graph import SubmapGraph
from slam.graph.submap_view import SubmapView
from slam.graph.wall_candidates import WallCandidates
from slam.mapping.surfel_map import SurfelMap

MAX_CANDIDATES, ENOUGH = 6, 3
"""Most earlier submaps in which a new one is searched, and number of hits that end the search."""
POOR: Final = 0.9
"""Standard deviation of a path through the graph above which it counts as broken, metres."""
STANDING_ALONE: Final = 1.2
"""Number of fully agreeing key scans with which a loop over a break needs no confirmation by another loop."""
WALL_SIGMAS: Final = np.array([0.3, 0.3, 0.05])
"""Standard deviations of a pose from walls alone: metres and radians."""
HEADING_UNKNOWN_SIGMAS: Final = np.array([0.5, 0.5, 2.0])
"""Standard deviations with which a place is searched after a break, with any heading: metres and radians."""


class LoopFinder:
    """Finds a submap in earlier ones, and adds valid loops to the graph."""

    def __init__(
        self, graph: SubmapGraph, condensed: CondensedGraph, matching: LeastSquaresConfig, config: SurfelMapConfig
    ) -> None:
        self._graph, self._condensed, self._config = graph, condensed, config
        self._search, self._candidates = LoopSearch(graph, matching, config), LoopCandidates(graph, condensed)
        self._walls, self._waiting = WallCandidates(), WaitingLoops(graph)
        self.tried = 0  # number of candidates so far

    def add(self, submap: Submap) -> None:
        """Add a submap that is finished, in which later ones can be found."""
        self._candidates.add(submap)
        surfels = SurfelMap(self._config, self._search.map_of(submap).grid).surfels
        self._walls.add(submap, surfels, self._config.cell)

    def find(self, submap: Submap) -> int:
        """Search a submap in the earlier ones, most certain first; return the number of added loops."""
        candidates, found, view = self._candidates.nearby(submap), 0, self._search.view(submap)
        for other, covariance in candidates[:MAX_CANDIDATES]:
            self.tried += 1
            loop = self._search.find(view, other, covariance, "odometry")
            if loop is not None:
                poor = covariance[0, 0] + covariance[1, 1] > POOR**2
                found += self._add(loop, poor and not _stands_alone(loop))
                if found >= ENOUGH:
                    break
        if submap.broken and not found:
            found += self._find_after_break(view)
        out_of_reach = (self._candidates.is_out_of_reach(submap, *candidate) for candidate in candidates)
        if not found and any(out_of_reach):
            found += self._find_by_walls(view)
        return found

    def keep(self) -> None:
        """Remove submaps that have left the graph."""
        self._candidates.keep()
        self._walls.keep(self._graph.submaps)
        self._waiting.forget()

    def _find_after_break(self, view: SubmapView) -> int:
        """Search a submap with any heading near a break of the front end."""
        for other in self._candidates.beside_break(view.submap):
            self.tried += 1
            loop = self._search.find(view, other, np.diag(HEADING_UNKNOWN_SIGMAS**2), "break")
            if loop is not None:
                return self._add(loop, not _stands_alone(loop))
        return 0

    def _find_by_walls(self, view: SubmapView) -> int:
        """Search a submap at the poses that its walls alone suggest; another loop must confirm the result."""
        submap, added = view.submap, 0
        covariance, covariances = np.diag(WALL_SIGMAS**2), self._candidates.covariances_from(view.submap)
        for candidate in self._walls.of(submap, self._candidates.apart(submap)):
            if not self._candidates.is_plausible(candidate, submap, covariances[candidate.other.number]):
                continue
            self.tried += 1
            loop = self._search.find_near(view, candidate.other, candidate.T_other_submap, covariance, "walls")
            if loop is not None and not loop.ambiguous:
                added += self._add(loop, doubtful=True)
        return added

    def _add(self, loop: Loop, doubtful: bool) -> int:
        """Add a loop, a doubtful one only if another confirms it; return the number of added loops."""
        loops = self._waiting.confirmed(loop, self._condensed.steps(), self._believed()) if doubtful else [loop]
        for one in loops:
            self._graph.add_loop(renumbered(one, len(self._graph.loops)))
        return len(loops)

    def _believed(self) -> list[Loop]:
        """Loops that the graph of submaps accepts."""
        weighed = zip(self._graph.loops, self._condensed.weights, strict=False)
        return [loop for loop, weight in weighed if weight > BELIEVED]


def _stands_alone(loop: Loop) -> bool:
    return loop.share * loop.tested >= STANDING_ALONE
