"""A loop: a submap found again in an earlier one, by how much they agree, and whether that is believed."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from slam.graph.pose_graph import Edge
from slam.lines.segments import IntArray
from slam.pose import FloatArray

Proposal = Literal["odometry", "walls", "break"]
"""Origin of a proposal: the way through the graph, the walls alone, or a place where the front end broke."""


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """Result of a comparison of two submaps."""

    number: int
    submap: int
    other: int
    """The earlier one."""
    T_other_submap: FloatArray
    """(3,): takes what ``local`` was while the submap was made to what it was while the other was."""
    proposal: Proposal
    tested: int
    """Key scans of the submap that lie near the other's path there ..."""
    agreeing: int
    """... and those of them that agree with it."""
    share: float
    """Mean agreement of the tested ones, beams that saw through walls taken off."""
    ambiguous: bool
    """True where a second place was nearly as good, so that the direction between the two is left open."""
    edges: tuple[Edge, ...]
    """One for each key scan that agrees, from the node of the other submap to its own."""
    scan: int
    """Number of the last scan of the submap."""

    @property
    def text(self) -> str:
        """The loop in words, as in: submap 41 found in submap 3, 14 of 15 scans agree."""
        open_side = ", one direction left open" if self.ambiguous else ""
        agree = f"{self.agreeing} of {self.tested} scans agree{open_side}"
        return f"submap {self.submap} found in submap {self.other}, {agree}"


def loop_keys(
    loops: Iterable[Loop], keys_of: Mapping[int, Sequence[int]], key_of: Callable[[int], int], poses: FloatArray
) -> IntArray:
    """Places of loops, (L, 2): numbers of two key scans that each loop joins.

    The first is the middle one of those of the found submap that agree; the second is the nearest to it of the submap
    in which it was found.

    ``keys_of`` has the key scans of every submap, ``key_of`` gives that of a node; ``poses`` (K, 3) are those of all.
    """
    pairs = []
    for loop in loops:
        own, others = key_of(loop.edges[len(loop.edges) // 2].second), np.array(keys_of[loop.other])
        distances = np.hypot(*(poses[others] - poses[own])[:, :2].T)
        pairs.append((own, others[np.argmin(distances)]))
    return np.array(pairs, np.int64).reshape(-1, 2)
