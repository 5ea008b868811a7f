"""Poses of a submap in earlier ones from walls alone, if the graph's pose is too uncertain."""

from collections.abc import Collection, Sequence
from typing import Final, NamedTuple

from slam.graph.constellation import Constellation
from slam.graph.submap import Submap
from slam.graph.wall_places import propose_places
from slam.matching.coarse_search import PLACE_X, SCORE
from slam.pose import FloatArray, compose_poses, inverse_poses

MAX_PAIRS: Final = 30
"""Number of earlier submaps that a submap is compared with."""
MAX_PLACES: Final = 3
"""Largest number of poses in one earlier submap."""
MAX_CANDIDATES: Final = 8
"""Largest number of poses in all earlier submaps together."""


class WallCandidate(NamedTuple):
    """A pose to verify."""

    score: float
    other: Submap
    T_other_submap: FloatArray
    """(3,): pose between the frames ``local`` of the two submaps."""


class WallCandidates:
    """The constellations of finished submaps, each in the frame of its middle key scan."""

    def __init__(self) -> None:
        self._constellations: dict[int, Constellation] = {}

    def add(self, submap: Submap, surfels: FloatArray, cell: float) -> None:
        """Add the map of a finished submap: its surfels (S, 8), frame ``local``, and the width of its cells."""
        self._constellations[submap.number] = Constellation.of_surfels(surfels, _middle(submap), cell)

    def keep(self, numbers: Collection[int]) -> None:
        """Remove all submaps but those with these numbers."""
        self._constellations = {number: one for number, one in self._constellations.items() if number in numbers}

    def of(self, submap: Submap, others: Sequence[Submap]) -> list[WallCandidate]:
        """Return poses of a submap in others, best score first; only the first MAX_PAIRS of the others are tried."""
        own, middle, rows = self._constellations[submap.number], inverse_poses(_middle(submap)), []
        for other in others[:MAX_PAIRS]:
            for place in propose_places(own, self._constellations[other.number], MAX_PLACES):
                T_other_submap = compose_poses(compose_poses(_middle(other), place[PLACE_X:]), middle)
                rows.append(WallCandidate(float(place[SCORE]), other, T_other_submap))
        rows.sort(key=lambda row: -row.score)
        return rows[:MAX_CANDIDATES]


def _middle(submap: Submap) -> FloatArray:
    """Return the pose (3,) of the key scan in its middle."""
    pose: FloatArray = submap.path[len(submap.path) // 2]
    return pose
