"""A finished submap in the form in which it is compared with others: the poses and facets of its key scans."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from slam.graph.key_scan import KeyScan
from slam.graph.single_poses import between
from slam.graph.submap import REACH, Submap
from slam.lines.facets import NX, NY, X, Y
from slam.lines.segments import IntArray
from slam.mapping.free_beams import FreeBeams, free_beams
from slam.pose import FloatArray

MAX_FACETS: Final = 200
"""Largest number of facets that are searched together."""


class SubmapView:
    """The key scans of a submap."""

    def __init__(self, submap: Submap, keys: Sequence[KeyScan], no_echo_reach: float) -> None:
        self.submap, self.path = submap, submap.path
        self.keys = [keys[number] for number in submap.keys]
        self._no_echo_reach = no_echo_reach
        self._beams: dict[int, FreeBeams] = {}

    def beams(self, at: int) -> FreeBeams:
        """The beams of one of its key scans."""
        if at not in self._beams:
            self._beams[at] = free_beams(self.keys[at].scan, self._no_echo_reach)
        return self._beams[at]

    def joint_scan(self, middle: int, members: IntArray) -> FloatArray:
        """Return the facets (F, 7) of some key scans together, in the frame of the one in the middle."""
        origin = self.path[middle]
        parts = [_moved(self.keys[at].facets, between(origin, self.path[at])) for at in members.tolist()]
        facets = np.concatenate(parts)
        facets = facets[np.hypot(facets[:, X], facets[:, Y]) < REACH]
        return np.ascontiguousarray(facets[:: len(facets) // MAX_FACETS + 1])


def _moved(facets: FloatArray, pose: FloatArray) -> FloatArray:
    """Transform facets (F, 7) of a scan by ``pose`` (3,)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    x, y, nx, ny = facets[:, X], facets[:, Y], facets[:, NX], facets[:, NY]
    moved = facets.copy()
    moved[:, X], moved[:, Y] = pose[0] + c * x - s * y, pose[1] + s * x + c * y
    moved[:, NX], moved[:, NY] = c * nx - s * ny, s * nx + c * ny
    return moved
