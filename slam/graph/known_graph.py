"""The graph of an earlier run, with its key scans, for a run that continues it."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from slam.graph.closure import ClosedRun
from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.pose_graph import NO_LOOP, Edge, Edges
from slam.graph.run_graph import RunGraph
from slam.graph.submap import Submap
from slam.pose import FloatArray

GAP = 2
"""Step from the last submap number of the earlier run to the first new one; 2, so that they are not consecutive."""


@dataclass(frozen=True, eq=False)
class KnownGraph:
    """Key scans, and the solved graph of them; their scan indices are below zero."""

    graph: RunGraph
    keys: tuple[KeyScan, ...]

    @classmethod
    def of(cls, graph: RunGraph, keys: tuple[KeyScan, ...]) -> Self:
        """Return the graph of a run and its key scans, renumbered for a run that continues it."""
        past = int(graph.scans.max()) + 1
        loops = tuple(replace(loop, scan=min(loop.scan - past, -1)) for loop in graph.loops)
        graph = replace(graph, scans=graph.scans - past, loops=loops)
        indices = graph.scans.tolist()
        return cls(graph, tuple(replace(key, index=index) for key, index in zip(keys, indices, strict=True)))

    @classmethod
    def of_run(cls, closed: ClosedRun) -> Self:
        """Return the graph of a finished run."""
        return cls.of(RunGraph.of(closed), closed.keys)

    @property
    def next_submap(self) -> int:
        """Number of the first submap of the continuing run."""
        return max(submap.number for submap in self.graph.submaps) + GAP

    @property
    def loops(self) -> list[Loop]:
        """Loops of the graph, with their edges."""
        return list(self.graph.loops)

    @property
    def submaps(self) -> dict[int, Submap]:
        """Submaps of the graph by their numbers, finished."""
        submaps = {one.number: replace(one, keys=list(one.keys)) for one in self.graph.submaps}
        for submap in submaps.values():
            submap.finish(self.keys)
        return submaps

    @property
    def edges(self) -> list[Edge]:
        """All edges to key scans, those of loops last."""
        own = [edge for edge in self._own if not self._is_tie(edge)]
        return [*own, *(edge for loop in self.loops for edge in loop.edges)]

    @property
    def ties(self) -> dict[tuple[int, int], Edge]:
        """Edges between two submaps, by their numbers."""
        number = {submap.node: submap.number for submap in self.graph.submaps}
        ties = [edge for edge in self._own if self._is_tie(edge)]
        ties = [edge._replace(first=number[edge.first], second=number[edge.second]) for edge in ties]
        return {(tie.first, tie.second): tie for tie in ties}

    @cached_property
    def _own(self) -> list[Edge]:
        return [edge for edge in _rows(self.graph.edges) if edge.loop == NO_LOOP]

    @cached_property
    def _origins(self) -> frozenset[int]:
        return frozenset(submap.node for submap in self.graph.submaps)

    def _is_tie(self, edge: Edge) -> bool:
        return edge.first in self._origins and edge.second in self._origins

    @property
    def nodes(self) -> list[FloatArray]:
        """Poses of all nodes."""
        return list(np.array(self.graph.nodes))


def _rows(edges: Edges) -> list[Edge]:
    columns = edges.first.tolist(), edges.second.tolist(), edges.measured, edges.information, edges.loop.tolist()
    return [Edge(*row) for row in zip(*columns, strict=True)]
