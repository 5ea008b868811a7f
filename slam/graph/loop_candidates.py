"""The earlier submaps that may share walls with one that was just finished."""

from typing import Final

import numpy as np

from slam.graph.condensed import CondensedGraph
from slam.graph.loop_check import distances_to
from slam.graph.loop_search import MOST_WINDOW
from slam.graph.single_poses import between, composed
from slam.graph.submap import Submap
from slam.graph.submap_graph import SubmapGraph
from slam.graph.surest_paths import surest_covariances
from slam.graph.wall_candidates import WallCandidate
from slam.pose import FloatArray, compose_poses, wrap_angle

NEAR: Final = 3.0
"""Metres between two paths ..."""
SIGMAS: Final = 3.0
"""... and so many standard deviations of where they lie, within which a submap is sought."""
GAP_COST: Final = 0.3
"""Standard deviation in metres that counts as much as a metre between the paths when candidates are ordered."""
NEIGHBOURS: Final = 2
"""Submaps before a new one that share its walls without a loop."""
THINKABLE: Final = 50.0
"""chi^2 of a place from walls alone by what the graph says, at most."""
BREAK_REACH, BREAK_CANDIDATES = 5.0, 3
"""After a break of the front end: so near, metres, must a submap's path be, and so many are tried with any heading."""


class LoopCandidates:
    """Finished submaps, and those among them that one may be found in."""

    def __init__(self, graph: SubmapGraph, condensed: CondensedGraph) -> None:
        self._graph, self._condensed = graph, condensed
        self._finished: list[Submap] = []

    def add(self, submap: Submap) -> None:
        """Add a submap that is finished."""
        self._finished.append(submap)

    def keep(self) -> None:
        """Forget submaps that have left the graph."""
        self._finished = [submap for submap in self._finished if submap.number in self._graph.submaps]

    def nearby(self, submap: Submap) -> list[tuple[Submap, FloatArray]]:
        """Earlier submaps that may share walls with one, and the covariance of each seen from it, the surest first."""
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
        """Earlier submaps beside where the front end lost its way, the nearest first."""
        own = self._places(submap)
        earlier = [other for other in self._finished[:-1] if other.number < submap.number]
        near = [(float(distances_to(own, self._places(other)).min()), other) for other in earlier]
        near = sorted((row for row in near if row[0] < BREAK_REACH), key=lambda row: row[0])
        return [other for _, other in near[:BREAK_CANDIDATES]]

    def apart(self, submap: Submap) -> list[Submap]:
        """All earlier submaps but neighbours, the nearest first."""
        nearest_first = np.argsort(self._distances(submap), kind="stable").tolist()
        others = [self._finished[at] for at in nearest_first]
        return [other for other in others if not self._are_neighbours(other, submap)]

    def covariances_from(self, submap: Submap) -> dict[int, FloatArray]:
        """Covariance (3, 3) of every submap as seen from one, map axes, by their numbers."""
        submaps = list(self._graph.submaps.values())
        poses = np.array([self._graph.poses[other.node] for other in submaps])
        covariances = surest_covariances(submaps.index(submap), poses, self._condensed.hops())
        return {other.number: covariance for other, covariance in zip(submaps, covariances, strict=True)}

    def is_out_of_reach(self, submap: Submap, other: Submap, covariance: FloatArray) -> bool:
        """True where the graph says too little of where a submap lies, seen from another, for a search by that."""
        sigma = float(np.sqrt(max(covariance[0, 0], covariance[1, 1])))
        return SIGMAS * sigma > MOST_WINDOW or self._is_break_between(other, submap)

    def is_thinkable(self, candidate: WallCandidate, submap: Submap, covariance: FloatArray) -> bool:
        """True for a place that the graph does not rule out: a building may look alike from both ends.

        The covariance (3, 3) is that of the other as seen from the submap. Over a break the graph says nothing.
        """
        other = candidate.other
        if self._is_break_between(other, submap):
            return True
        seen = between(candidate.T_other_submap, other.T_local_submap)
        error = composed(self._graph.correction(submap), seen) - self._graph.poses[other.node]
        error[2] = wrap_angle(float(error[2]))
        return float(error @ np.linalg.solve(covariance, error)) < THINKABLE

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
        return any(one.broken for number, one in self._graph.submaps.items() if low < number <= high)

    def _distances(self, submap: Submap) -> FloatArray:
        """Metres from the middle of a submap to those of all that were finished before the last, (F,)."""
        corrections = np.array([self._graph.correction(other) for other in self._finished[:-1]]).reshape(-1, 3)
        local = np.array([[*other.middle, 0.0] for other in self._finished[:-1]]).reshape(-1, 3)
        middles = compose_poses(corrections, local)
        own = composed(self._graph.correction(submap), np.append(submap.middle, 0.0))
        return np.asarray(np.hypot(*(middles - own)[:, :2].T))

    def _places(self, submap: Submap) -> FloatArray:
        """Poses (K, 3) of the key scans of a finished submap, as the graph has them."""
        return compose_poses(self._graph.correction(submap), submap.path)
