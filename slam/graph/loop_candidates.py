"""The earlier submaps that may share walls with a newly finished one."""

from typing import Final

import numpy as np

from slam.graph.condensed import CondensedGraph
from slam.graph.loop_check import distances_to
from slam.graph.loop_search import MAX_WINDOW
from slam.graph.single_poses import between, composed
from slam.graph.submap import Submap
from slam.graph.submap_graph import SubmapGraph
from slam.graph.surest_paths import surest_covariances
from slam.graph.wall_candidates import WallCandidate
from slam.pose import FloatArray, compose_poses, wrap_angle

NEAR: Final = 3.0
"""Largest distance between the paths of two submaps, metres, if their relative pose is certain."""
SIGMAS: Final = 3.0
"""Standard deviations of the relative pose by which that distance is enlarged."""
GAP_COST: Final = 0.3
"""Candidates are sorted by their standard deviation, metres, plus this for each metre between the paths."""
NEIGHBOURS: Final = 2
"""Submaps whose numbers differ by at most this are neighbours: they see the same walls, and need no loop."""
MAX_POSE_CHI2: Final = 50.0
"""Largest chi^2 by which a pose found from walls alone may differ from the graph."""
BREAK_REACH, BREAK_CANDIDATES = 5.0, 3
"""After a break of the front end: largest distance of a submap's path, metres, and number of submaps that are tried
with any heading."""


class LoopCandidates:
    """Finished submaps; selects those in which a new one may be found again."""

    def __init__(self, graph: SubmapGraph, condensed: CondensedGraph) -> None:
        self._graph, self._condensed = graph, condensed
        self._finished: list[Submap] = []

    def add(self, submap: Submap) -> None:
        """Add a submap that is finished."""
        self._finished.append(submap)

    def keep(self) -> None:
        """Remove submaps that have left the graph."""
        self._finished = [submap for submap in self._finished if submap.number in self._graph.submaps]

    def nearby(self, submap: Submap) -> list[tuple[Submap, FloatArray]]:
        """Return earlier submaps that may share walls with one, most certain first.

        The covariance of each is relative to the given submap.
        """
        covariances = self.covariances_from(submap)
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

    def beside_break(self, submap: Submap) -> list[Submap]:
        """Return earlier submaps near a break of the front end, nearest first."""
        own = self._places(submap)
        earlier = [other for other in self._finished[:-1] if other.number < submap.number]
        near = [(float(distances_to(own, self._places(other)).min()), other) for other in earlier]
        near = sorted((row for row in near if row[0] < BREAK_REACH), key=lambda row: row[0])
        return [other for _, other in near[:BREAK_CANDIDATES]]

    def apart(self, submap: Submap) -> list[Submap]:
        """Return all earlier submaps except neighbours, nearest first."""
        nearest_first = np.argsort(self._distances(submap), kind="stable").tolist()
        others = [self._finished[at] for at in nearest_first]
        return [other for other in others if not self._are_neighbours(other, submap)]

    def covariances_from(self, submap: Submap) -> dict[int, FloatArray]:
        """Return the covariance (3, 3) of every submap relative to one, map axes, by their numbers."""
        submaps = list(self._graph.submaps.values())
        poses = np.array([self._graph.poses[other.node] for other in submaps])
        covariances = surest_covariances(submaps.index(submap), poses, self._condensed.steps())
        return {other.number: covariance for other, covariance in zip(submaps, covariances, strict=True)}

    def is_out_of_reach(self, submap: Submap, other: Submap, covariance: FloatArray) -> bool:
        """Return True if the graph's relative pose of two submaps is too uncertain for a search."""
        sigma = float(np.sqrt(max(covariance[0, 0], covariance[1, 1])))
        return SIGMAS * sigma > MAX_WINDOW or self._is_break_between(other, submap)

    def is_plausible(self, candidate: WallCandidate, submap: Submap, covariance: FloatArray) -> bool:
        """Return True if the graph does not contradict a pose: a building may look alike from both ends.

        ``covariance`` (3, 3) is that of the candidate's submap relative to ``submap``. Over a break the graph has no
        information.
        """
        other = candidate.other
        if self._is_break_between(other, submap):
            return True
        seen = between(candidate.T_other_submap, other.T_local_submap)
        error = composed(self._graph.correction(submap), seen) - self._graph.poses[other.node]
        error[2] = wrap_angle(float(error[2]))
        return float(error @ np.linalg.solve(covariance, error)) < MAX_POSE_CHI2

    def _are_neighbours(self, other: Submap, submap: Submap) -> bool:
        """Return True if two submaps share key scans, or follow each other without a break."""
        if set(other.keys) & set(submap.keys):
            return True
        low, high = sorted((other.number, submap.number))
        if high - low > NEIGHBOURS:
            return False
        return not self._is_break_between(other, submap)

    def _is_break_between(self, other: Submap, submap: Submap) -> bool:
        low, high = sorted((other.number, submap.number))
        return any(one.broken for number, one in self._graph.submaps.items() if low < number <= high)

    def _distances(self, submap: Submap) -> FloatArray:
        """Return the distances from the middle of a submap to those of all finished before the last, (F,), metres."""
        corrections = np.array([self._graph.correction(other) for other in self._finished[:-1]]).reshape(-1, 3)
        local = np.array([[*other.middle, 0.0] for other in self._finished[:-1]]).reshape(-1, 3)
        middles = compose_poses(corrections, local)
        own = composed(self._graph.correction(submap), np.append(submap.middle, 0.0))
        return np.asarray(np.hypot(*(middles - own)[:, :2].T))

    def _places(self, submap: Submap) -> FloatArray:
        """Return the poses (K, 3) of the key scans of a finished submap in the graph."""
        return compose_poses(self._graph.correction(submap), submap.path)
