"""Agreement of two loops: whether both correct the later submaps in the same way, within the uncertainty of the graph.

A single loop may be wrong, as a building has places that look alike. Two loops of submaps without a common scan rarely
agree on the same error (after Mangelson et al., "Pairwise consistent measurement set maximization", ICRA 2018).
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from slam.graph.loop import Loop
from slam.graph.submap_graph import SubmapGraph
from slam.graph.surest_paths import SubmapSteps, surest_covariances
from slam.pose import FloatArray, compose_poses, inverse_poses, wrap_angle

LOOP_SIGMAS: Final = np.array([0.15, 0.15, 0.03])
"""Standard deviations of the error of one loop, metres and radians."""
AGREED: Final = 11.3
"""chi^2 of three degrees of freedom below which two loops agree; 0.99 of correct pairs do."""
FARTHEST: Final = 0.7
"""Two loops cannot be compared if the path between them has a larger standard deviation than this, metres."""
MIN_OWN: Final = 3
"""Number of key scans, not in the other loop, that make a loop independent."""
MAX_WAITING: Final = 30
"""Largest number of loops that wait for confirmation by another one."""
GRAPH_SHARE: Final = 0.25
"""Factor from the variances of the candidate search to those of the graph."""


class Consistency:
    """Compares one loop with others, in the present graph."""

    def __init__(self, graph: SubmapGraph, steps: SubmapSteps, loop: Loop) -> None:
        self._graph, self._loop = graph, loop
        numbers = list(graph.submaps)
        self._at = {number: k for k, number in enumerate(numbers)}
        poses = np.array([graph.poses[graph.submaps[number].node] for number in numbers])
        steps = steps._replace(covariance=GRAPH_SHARE * steps.covariance)
        self._from_submap = surest_covariances(self._at[loop.submap], poses, steps)
        self._from_other = surest_covariances(self._at[loop.other], poses, steps)

    def chi_squared(self, other: Loop) -> float:
        """Return chi^2, of 3 degrees of freedom, of the difference between the poses that two loops give to a submap.

        It is the submap of the second loop; infinite if the loops cannot be compared.
        """
        graph = self._graph
        if not self._is_near(other):
            return np.inf
        own = graph.poses[graph.submaps[other.submap].node]
        moved, thought = compose_poses(_jump(self._loop, graph), own), compose_poses(_jump(other, graph), own)
        covariance = self._covariance(other, moved)
        if not covariance[0, 0] + covariance[1, 1] <= FARTHEST**2:
            return np.inf
        error = thought - moved
        error[2] = wrap_angle(float(error[2]))
        return float(error @ np.linalg.solve(covariance, error))

    def _is_near(self, other: Loop) -> bool:
        """Return True if the paths through the graph to both its submaps may be short enough."""
        along, back = self._from_submap[self._at[other.submap]], self._from_other[self._at[other.other]]
        return bool(along[0, 0] + along[1, 1] + back[0, 0] + back[1, 1] <= FARTHEST**2)

    def _covariance(self, other: Loop, there: FloatArray) -> FloatArray:
        """Return the covariance (3, 3) of the difference of the two loops, at the pose given by the first one."""
        graph = self._graph
        turn = float(_jump(self._loop, graph)[2])
        c, s = np.cos(turn), np.sin(turn)
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        along = R @ self._from_submap[self._at[other.submap]] @ R.T
        loops = np.diag(LOOP_SIGMAS**2)
        first = compose_poses(_jump(self._loop, graph), graph.poses[graph.submaps[self._loop.submap].node])
        begun = graph.poses[graph.submaps[other.other].node]
        back = _carried(self._from_other[self._at[other.other]], begun, there)
        return np.asarray(along + back + _carried(loops, first, there) + loops)


class WaitingLoops:
    """Loops that no other loop confirms yet."""

    def __init__(self, graph: SubmapGraph) -> None:
        self._graph, self._waiting = graph, list[Loop]()

    def confirmed(self, loop: Loop, steps: SubmapSteps, believed: Iterable[Loop]) -> list[Loop]:
        """Return the loop and the waiting ones that it agrees with.

        A loop that agrees with no other waits too, and the list is empty.
        """
        consistency = Consistency(self._graph, steps, loop)
        partners = [other for other in self._waiting if self._agree(consistency, loop, other)]
        if not partners and not any(self._agree(consistency, loop, other) for other in believed):
            self._waiting = [*self._waiting, loop][-MAX_WAITING:]
            return []
        self._waiting = [other for other in self._waiting if all(other is not partner for partner in partners)]
        return [*partners, loop]

    def forget(self) -> None:
        """Drop all waiting loops, after the nodes of the graph were renumbered."""
        self._waiting = []

    def _agree(self, consistency: Consistency, loop: Loop, other: Loop) -> bool:
        """Return True if two loops agree, and each has key scans that the other does not have."""
        own, others = ({edge.second for edge in one.edges} for one in (loop, other))
        independent = min(len(own - others), len(others - own)) >= MIN_OWN and loop.submap != other.submap
        return independent and consistency.chi_squared(other) < AGREED


def renumbered(loop: Loop, number: int) -> Loop:
    """Return the same loop with another number."""
    return replace(loop, number=number, edges=tuple(edge._replace(loop=number) for edge in loop.edges))


def _jump(loop: Loop, graph: SubmapGraph) -> FloatArray:
    """Return the motion (3,), map frame, by which a loop would correct its submap."""
    submap, other = graph.submaps[loop.submap], graph.submaps[loop.other]
    claimed = compose_poses(graph.correction(other), loop.T_other_submap)
    return compose_poses(claimed, inverse_poses(graph.correction(submap)))


def _carried(covariance: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Transform a covariance (3, 3) of a pose at ``start`` (3,) to one rigidly attached to it at ``end``."""
    J = np.eye(3)
    J[0, 2], J[1, 2] = start[1] - end[1], end[0] - start[0]
    return np.asarray(J @ covariance @ J.T)
