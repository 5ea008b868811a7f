"""Poses of a submap in another one, from their walls alone and without a prior.

Pairs of walls vote for poses (wall_votes.py); each of these is refined and scored (place_evidence.py). The results must
be verified, as a building has places that look alike.
"""

import numpy as np

from slam.graph.constellation import Constellation
from slam.graph.place_evidence import weigh_places
from slam.graph.wall_votes import places_voted_for
from slam.matching.coarse_search import HEADING, PLACE_X, PLACE_Y, SCORE
from slam.pose import FloatArray, wrap_angles

SAME_DISTANCE, SAME_ANGLE = 0.4, 0.1
"""Poses nearer than this, metres and radians, count as one."""


def propose_places(submap: Constellation, other: Constellation, most: int = 6) -> FloatArray:
    """Return poses of a submap in another one from their walls alone, (N, 4): SCORE, PLACE_X, PLACE_Y, HEADING.

    They are ``T_other_submap``, best first. The scores compare poses; they do not show whether the two submaps overlap.
    """
    places = places_voted_for(submap.walls, other.walls)
    weigh_places(places, submap, other)
    return _distinct(places[np.argsort(-places[:, SCORE], kind="stable")], most)


def _distinct(places: FloatArray, most: int) -> FloatArray:
    """Return the poses (N, 4), best first, without those near a better one; ``most`` at most."""
    chosen = np.empty((0, 4))
    while len(places) and len(chosen) < most:
        best = places[0]
        chosen = np.vstack([chosen, best])
        distances = np.hypot(places[:, PLACE_X] - best[PLACE_X], places[:, PLACE_Y] - best[PLACE_Y])
        turns = np.abs(wrap_angles(places[:, HEADING] - best[HEADING]))
        places = places[(distances >= SAME_DISTANCE) | (turns >= SAME_ANGLE)]
    return chosen
