"""Covariance of the pose of every submap relative to one, along the most certain path; compiled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.lines.segments import IntArray
from slam.motion_model import carried
from slam.pose import FloatArray
from slam.small_matrices import add, write

TURN_COST = 25.0  # m^2 per rad^2: weight of the variance of the heading when paths are compared


class SubmapSteps(NamedTuple):
    """Steps from one submap to another that a path may take, in both directions."""

    first: IntArray
    """(H,): indices in the list of submaps."""
    second: IntArray
    covariance: FloatArray
    """(H, 3, 3): covariances, map axes."""


def surest_covariances(source: int, poses: FloatArray, steps: SubmapSteps) -> FloatArray:
    """Return the covariance (N, 3, 3) of the poses (N, 3) of all submaps relative to one of them, map axes.

    Infinite if no path leads there.
    """
    order = np.argsort(np.concatenate([steps.first, steps.second]), kind="stable")
    start = np.concatenate([steps.first, steps.second])[order]
    end = np.concatenate([steps.second, steps.first])[order]
    begins = np.searchsorted(start, np.arange(len(poses) + 1))
    covariance = np.concatenate([steps.covariance, steps.covariance])[order]
    return _surest(source, poses, begins, end, covariance)


@compiled
def _surest(source: int, poses: FloatArray, begins: IntArray, end: IntArray, step: FloatArray) -> FloatArray:
    """Dijkstra's algorithm; the neighbours of node n are ``end[begins[n]:begins[n + 1]]``."""
    count = len(poses)
    best, cost, known = np.full((count, 3, 3), np.inf), np.full(count, np.inf), np.zeros(count, np.bool_)
    best[source], cost[source] = 0.0, 0.0
    for _ in range(count):
        n = _surest_unknown(cost, known)
        if n < 0:
            break
        known[n] = True
        for k in range(begins[n], begins[n + 1]):
            other = end[k]
            if not known[other]:
                C = carried(best[n], poses[n, 1] - poses[other, 1], poses[other, 0] - poses[n, 0])
                add(C, step[k])
                total = C[0, 0] + C[1, 1] + TURN_COST * C[2, 2]
                if total < cost[other]:
                    write(best[other], C)
                    cost[other] = total
    return best


@compiled_on_views
def _surest_unknown(cost: FloatArray, known: NDArray[np.bool_]) -> int:
    """Return the unknown node of least cost, -1 if no path leads to one."""
    least, node = np.inf, -1
    for n in range(len(cost)):
        if not known[n] and cost[n] < least:
            least, node = cost[n], n
    return node
