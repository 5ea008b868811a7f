"""Pruning: redundant submaps are removed, so that the graph grows with the area and not with time.

A submap is redundant on three conditions. It was found in earlier submaps; its key scans agree with these nearly as
well as with itself, so that a place that has changed is kept; and near each of its key scans earlier ones were taken
with a similar heading. The edges of a redundant submap are replaced by ties between the neighbouring submaps. A few of
its scans become anchors, attached to the most certain of the submaps in which it was found.
"""

from collections.abc import Iterable
from typing import Final

import numpy as np

from slam.graph.anchors import Anchors
from slam.graph.condensed import CondensedGraph
from slam.graph.joined_edges import fused, inverted, joined
from slam.graph.pose_graph import Edge
from slam.graph.single_poses import between
from slam.graph.submap import Submap
from slam.graph.submap_graph import Remaining, SubmapGraph
from slam.pose import FloatArray, wrap_angles

DELAY: Final = 3
"""A submap is judged after this number of later ones: they may be found in it, or contradict its loops."""
BELIEVED: Final = 0.5
"""Least weight of a loop that counts."""
NEAR, TURNED = 1.0, np.radians(30.0)
"""Largest distance and heading difference, metres and radians, of two key scans that see the same."""
ENOUGH: Final = 6
"""A key scan is redundant if this many earlier ones see the same; so places that were driven only twice are kept."""
MIN_AGREEING: Final = 0.8
"""Least share of the key scans of a submap that agree with the submaps in which it was found."""
UNCHANGED: Final = 0.8
"""Least agreement of the key scans with an earlier submap, as a share of their agreement with their own submap."""


class Pruning:
    """Removes redundant submaps from a graph."""

    def __init__(self, graph: SubmapGraph, condensed: CondensedGraph) -> None:
        self.anchors = Anchors()
        self._graph, self._condensed = graph, condensed
        self._redundant: set[int] = set()

    def prune(self, finished: int) -> Remaining | None:
        """Judge the submaps before the last finished one; if one was removed, return the remaining parts of the graph.

        A redundant submap is only removed if the one before it is gone, or the one after it is redundant too: two
        neighbours share half of their key scans.
        """
        number = finished - DELAY
        if self._is_redundant(number + 1):
            self._redundant.add(number + 1)
        redundant = number in self._redundant
        self._redundant.discard(number)
        if not redundant or (number - 1 in self._graph.submaps and number + 1 not in self._redundant):
            return None
        return self._take_out(number)

    def _is_redundant(self, number: int) -> bool:
        submaps = self._graph.submaps
        submap = submaps.get(number)
        if submap is None or number == next(iter(submaps)):
            return False
        return self._is_found(submap) and self._is_covered(submap)

    def _is_found(self, submap: Submap) -> bool:
        """Return True if a submap and its key scans agree with earlier ones.

        The evidence comes from the loops of the submap, and from those of other submaps with the same key scans.
        """
        graph, number = self._graph, submap.number
        weights = self._condensed.weights.tolist()
        loops = [loop for loop, weight in zip(graph.loops, weights, strict=True) if weight > BELIEVED]
        best = max((loop.share for loop in loops if loop.submap == number), default=0.0)
        if best < UNCHANGED * float(np.mean([graph.keys[k].agreeing_share for k in submap.keys])):
            return False
        beside = [loop for loop in loops if abs(loop.submap - number) <= 1]
        agreeing = {graph.number_of(edge.second) for loop in beside for edge in loop.edges}
        return len(agreeing.intersection(submap.keys)) >= MIN_AGREEING * len(submap.keys)

    def _is_covered(self, submap: Submap) -> bool:
        """Return True if near every key scan of a submap there are ENOUGH key scans of earlier submaps."""
        graph = self._graph
        earlier = [k for k in range(submap.keys[0]) if max(graph.keys[k].submaps) < submap.number - 1]
        own, others = self._poses(submap.keys), self._poses(earlier)
        offsets = own[:, None] - others[None]
        near = np.hypot(offsets[..., 0], offsets[..., 1]) < NEAR
        near &= np.abs(wrap_angles(offsets[..., 2])) < TURNED
        return bool((near.sum(axis=1) >= ENOUGH).all())

    def _poses(self, keys: Iterable[int]) -> FloatArray:
        return np.array([self._graph.poses[self._graph.key_nodes[number]] for number in keys]).reshape(-1, 3)

    def _take_out(self, number: int) -> Remaining | None:
        """Replace a submap by ties and anchors, and remove it."""
        graph = self._graph
        edges = _from(number, self._condensed.edges_of(number))
        earlier = [edge for edge in edges if edge.second < number - DELAY]
        if not earlier:
            return None
        surest = max(earlier, key=lambda edge: float(np.linalg.eigvalsh(edge.information[:2, :2])[0]))
        self._anchor(graph.submaps[number], graph.submaps[surest.second])
        for tie in _star(surest, edges):
            graph.add_tie(tie)
        left = graph.remove({number})
        self._condensed.keep_loops(left.loops)
        return left

    def _anchor(self, submap: Submap, other: Submap) -> None:
        """Keep the poses of the first and the last of the key scans that are removed with a submap.

        Between the two the others are interpolated.
        """
        graph = self._graph
        leaving = [number for number in submap.keys if graph.keys[number].submaps == (submap.number,)]
        origin = graph.poses[other.node]
        for number in sorted({*leaving[:1], *leaving[-1:]}):
            key, pose = graph.keys[number], graph.poses[graph.key_nodes[number]]
            self.anchors.add(key.index, key.T_local_laser, other.number, between(origin, pose))


def _from(number: int, edges: Iterable[Edge]) -> list[Edge]:
    """Return the edges of a submap relative to it, one for each other submap."""
    seen: dict[int, Edge] = {}
    for edge in edges:
        edge = edge if edge.first == number else inverted(edge)
        seen[edge.second] = fused(seen[edge.second], edge) if edge.second in seen else edge
    return list(seen.values())


def _star(surest: Edge, edges: Iterable[Edge]) -> list[Edge]:
    """Return the edges that replace a removed node: from its neighbour at ``surest`` to each other neighbour.

    Between that neighbour and any other one their covariance is exact; between two others it is too large.
    """
    back = inverted(surest)
    ties = [joined(back, edge) for edge in edges if edge.second != surest.second]
    return [tie if tie.first < tie.second else inverted(tie) for tie in ties]
