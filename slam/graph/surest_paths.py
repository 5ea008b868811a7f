"""Covariance of the place of every submap as seen from one, along the surest path; compiled."""

import heapq
from typing import NamedTuple

import numpy as np

from slam.compiled import compiled
from slam.lines.segments import IntArray
from slam.pose import FloatArray

TURN_COST = 25.0  # m^2 per rad^2: weight of the variance of the heading when paths are compared


class Hops(NamedTuple):
    """Steps between submaps, in both directions."""

    first: IntArray
    """(H,): indices in the list of submaps."""
    second: IntArray
    covariance: FloatArray
    """(H, 3, 3): covariances, map axes."""


def surest_covariances(source: int, poses: FloatArray, hops: Hops) -> FloatArray:
    """Return the covariance (N, 3, 3) of the poses (N, 3) of all submaps relative to one of them, map axes.

    Infinite if no path leads there.
    """
    order = np.argsort(np.concatenate([hops.first, hops.second]), kind="stable")
    start = np.concatenate([hops.first, hops.second])[order]
    end = np.concatenate([hops.second, hops.first])[order]
    begins = np.searchsorted(start, np.arange(len(poses) + 1))
    covariance = np.concatenate([hops.covariance, hops.covariance])[order]
    return _surest(source, poses, begins, end, covariance)


@compiled
def _surest(source: int, poses: FloatArray, begins: IntArray, end: IntArray, hop: FloatArray) -> FloatArray:
    """Dijkstra's algorithm; the neighbours of node n are ``end[begins[n]:begins[n + 1]]``."""
    count = len(poses)
    best, known = np.full((count, 3, 3), np.inf), np.zeros(count, np.bool_)
    cost = np.full(count, np.inf)
    best[source], cost[source] = 0.0, 0.0
    heap = [(0.0, source)]
    while len(heap) > 0:
        _, n = heapq.heappop(heap)
        if known[n]:
            continue
        known[n] = True
        for k in range(begins[n], begins[n + 1]):
            other = end[k]
            if known[other]:
                continue
            J = np.zeros((3, 3))
            J[0, 0] = J[1, 1] = J[2, 2] = 1.0
            J[0, 2], J[1, 2] = poses[n, 1] - poses[other, 1], poses[other, 0] - poses[n, 0]
            C = J @ best[n] @ J.T + hop[k]
            total = C[0, 0] + C[1, 1] + TURN_COST * C[2, 2]
            if total < cost[other]:
                best[other], cost[other] = C, total
                heapq.heappush(heap, (total, other))
    return best
