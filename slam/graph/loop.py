"""A loop: a submap found again in an earlier one, with the measured agreement."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from slam.graph.pose_graph import Edge
from slam.lines.segments import IntArray
from slam.pose import FloatArray

Proposal = Literal["odometry", "walls", "break"]
"""Source of a proposal: the path through the graph, the walls alone, or a break of the front end, at which a scan did
not fit those before: then all headings are tried in the submaps nearby."""


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """Result of a comparison of two submaps."""

    number: int
    submap: int
    other: int
    """Number of the earlier submap."""
    T_other_submap: FloatArray
    """(3,): drift of the frame ``local``, see ``KeyScan``, between the two submaps: it takes poses in ``local`` at the
    submap to ``local`` at the other one. Without drift it is zero."""
    proposal: Proposal
    tested: int
    """Number of key scans of the submap near the other's path."""
    agreeing: int
    """Number of those key scans that agree with the other submap."""
    share: float
    """Mean agreement of the tested key scans, minus the penalty for beams through walls."""
    ambiguous: bool
    """True if a second pose was nearly as good, so that the direction between the two is unconstrained."""
    edges: tuple[Edge, ...]
    """One edge for each agreeing key scan, from the node of the other submap to its own."""
    scan: int
    """Index of the last scan of the submap."""

    @property
    def text(self) -> str:
        """Describe the loop, as in: submap 41 found in submap 3, 14 of 15 scans agree."""
        open_side = ", one direction left open" if self.ambiguous else ""
        agree = f"{self.agreeing} of {self.tested} scans agree{open_side}"
        return f"submap {self.submap} found in submap {self.other}, {agree}"


def loop_keys(
    loops: Iterable[Loop], keys_of: Mapping[int, Sequence[int]], key_of: Callable[[int], int], poses: FloatArray
) -> IntArray:
    """Return places of loops, (L, 2): indices of the two key scans that each loop joins.

    The first is the middle one of the agreeing key scans of the found submap. The second is the key scan nearest to it
    in the submap in which the loop was found.

    ``keys_of`` has the key scans of every submap, ``key_of`` returns the key scan of a node, and ``poses`` (K, 3) are
    the poses of all key scans.
    """
    pairs = []
    for loop in loops:
        own, others = key_of(loop.edges[len(loop.edges) // 2].second), np.array(keys_of[loop.other])
        distances = np.hypot(*(poses[others] - poses[own])[:, :2].T)
        pairs.append((own, others[np.argmin(distances)]))
    return np.array(pairs, np.int64).reshape(-1, 2)
