"""Places proposed from walls alone, against a reference: how often the true one is among the first."""

from itertools import combinations
from time import thread_time
from typing import Final, NamedTuple

import numpy as np

from slam.graph.closed_map import map_of
from slam.graph.closure import ClosedRun
from slam.graph.constellation import Constellation
from slam.graph.submap import Submap
from slam.graph.wall_places import propose_places
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, compose_poses, path_lengths, relative_poses, wrap_angles
from slam.run.scoring.pose_errors import InterpolatedPoses

RANKS: Final = (1, 3, 6)
"""Values of k: the true place is searched among the first k proposals."""
NEAR: Final = 4.0
"""Two submaps are compared if their middles are nearer than this, metres."""
APART: Final = 12.0
"""Least path length between the two submaps, metres."""
MAX_PAIRS: Final = 200
RIGHT_METRES, RIGHT_RADIANS = 0.6, 0.12
"""A place counts as correct if it differs from the true one by less than this, metres and radians."""


class PlaceHits(NamedTuple):
    """Pairs of submaps at one place, and how often that place was proposed."""

    pairs: int
    hits: tuple[int, ...]
    """Pairs whose true place is among the first k proposals, for each k of RANKS."""
    seconds: float
    """Processor time of the proposals for all pairs; the walls of the submaps are found before, and not timed."""


def place_hits(closed: ClosedRun, reference: InterpolatedPoses) -> PlaceHits:
    """Propose the places of all submaps near an earlier one; of many pairs, MAX_PAIRS are drawn at random.

    ``reference`` has the poses of the base at all scans of the run.
    """
    middles = np.array([_middle(submap) for submap in closed.submaps], np.int64)
    at = closed.indices[middles]
    truth = compose_poses(reference.poses[at], closed.T_base_laser)
    pairs = [
        pair
        for pair in _near_pairs(truth, path_lengths(closed.local)[middles])
        if reference.known[at[list(pair)]].all()
    ]
    chosen = [pairs[k] for k in np.random.default_rng(0).permutation(len(pairs))[:MAX_PAIRS]]
    walls = {k: _constellation(closed, closed.submaps[k]) for k in {k for pair in chosen for k in pair}}
    ranks, began = [], thread_time()
    for other, own in chosen:
        places = propose_places(walls[own], walls[other], max(RANKS))
        ranks.append(rank_of(relative_poses(truth[other], truth[own]), places[:, 1:4]))
    hits = tuple(sum(rank < most for rank in ranks) for most in RANKS)
    return PlaceHits(len(chosen), hits, thread_time() - began)


def rank_of(true: FloatArray, places: FloatArray) -> int:
    """Return the index of the first of the places (N, 3) that is the true one (3,).

    If none is, the index is beyond RANKS.
    """
    offsets = places - true
    near = np.hypot(offsets[:, 0], offsets[:, 1]) < RIGHT_METRES
    right = np.flatnonzero(near & (np.abs(wrap_angles(offsets[:, 2])) < RIGHT_RADIANS))
    return int(right[0]) if len(right) else max(RANKS)


def _near_pairs(places: FloatArray, distances: FloatArray) -> list[tuple[int, int]]:
    """Return pairs of poses (N, 3), the earlier first, that are near each other with a long path (N,) between."""
    return [
        (a, b)
        for a, b in combinations(range(len(places)), 2)
        if distances[b] - distances[a] >= APART and np.hypot(*(places[b] - places[a])[:2]) < NEAR
    ]


def _constellation(closed: ClosedRun, submap: Submap) -> Constellation:
    """Return the walls of a submap, in the frame of its middle key scan."""
    made = map_of([(closed.keys[k], closed.local[k]) for k in submap.keys], SurfelMap(closed.map.config))
    return Constellation.of_surfels(made.surfels, closed.local[_middle(submap)], made.config.cell)


def _middle(submap: Submap) -> int:
    """Return the index of the key scan in the middle of a submap."""
    return submap.keys[len(submap.keys) // 2]
