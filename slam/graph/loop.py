"""A loop: a submap found again in an earlier one, by how much they agree, and whether that is believed."""

from dataclasses import dataclass
from typing import Literal

from slam.graph.pose_graph import Edge
from slam.pose import FloatArray

Proposal = Literal["odometry", "walls", "break"]
"""What proposed the place: the way through the graph, the walls alone, or the place where the front end broke."""


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """What was found when two submaps were compared."""

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
