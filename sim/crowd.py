"""The people of one or several worlds as arrays. Metres, seconds, map frame."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray, path_lengths
from slam.scenario.world_plan import Person

NOWHERE: Final = Person.model_construct(waypoints=((1e6, 1e6),), keep=0.0)
"""Placeholder person, for worlds that have fewer people than others."""


class Crowd(NamedTuple):
    """P people in each of W worlds; their paths have up to K nodes."""

    nodes: FloatArray
    """(W, P, K, 2): nodes of the closed path of each person."""
    distances: FloatArray
    """(W, P, K): metres from the first node to each."""
    node_counts: NDArray[np.int64]
    """(W, P): number of nodes."""
    habits: FloatArray
    """(W, P, 5): ``speed``, ``pause``, ``keep``, ``stance`` and ``stride`` of each ``Person``."""
    starts: FloatArray
    """(W, P): metres walked when a run begins."""
    leg_radii: FloatArray
    """(W, 2 P): radius of the left and right leg of the first person, then of the next."""


def crowd_of(worlds: Sequence[Sequence[Person]]) -> Crowd:
    """Collect the people of these worlds in arrays."""
    most = max(map(len, worlds))
    filled = [[*persons, *[NOWHERE] * (most - len(persons))] for persons in worlds]
    paths = [[_closed_path(person) for person in persons] for persons in filled]
    longest = max((len(path) for row in paths for path in row), default=1)
    nodes = np.zeros((len(worlds), most, longest, 2))
    distances = np.zeros(nodes.shape[:3])
    for w, row in enumerate(paths):
        for p, path in enumerate(row):
            nodes[w, p, : len(path)] = path
            distances[w, p, : len(path)] = path_lengths(path)
    people = [[(p.speed, p.pause, p.keep, p.stance, p.stride, p.start, p.leg_radius) for p in row] for row in filled]
    table = np.array(people, np.float64).reshape(len(worlds), most, 7)
    counts = np.array([[len(path) for path in row] for row in paths], np.int64).reshape(len(worlds), most)
    habits, starts = np.ascontiguousarray(table[..., :5]), np.ascontiguousarray(table[..., 5])
    return Crowd(nodes, distances, counts, habits, starts, np.repeat(table[..., 6], 2, axis=1))


def _closed_path(person: Person) -> FloatArray:
    """Return the nodes (K, 2) of a closed path; equal nodes in a row count once."""
    out = list(person.waypoints)
    back = [out[0]] if person.closed else out[-2::-1]
    points = [*out, *back] if len(out) > 1 else out
    kept = [point for k, point in enumerate(points) if k == 0 or point != points[k - 1]]
    return np.array(kept, np.float64)
