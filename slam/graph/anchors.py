"""Poses of the scans of removed submaps, each relative to a submap that remains."""

from array import array
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from slam.lines.segments import IntArray
from slam.pose import FloatArray, compose_poses


class PlacedScans(NamedTuple):
    """S scans in ascending order, whose poses are known."""

    indices: IntArray
    """(S,): index of each scan in the run."""
    local: FloatArray
    """(S, 3): T_local_laser of the scans."""
    poses: FloatArray
    """(S, 3): T_map_laser of the scans."""

    def with_others(self, others: "PlacedScans") -> "PlacedScans":
        """Join these and others, which have no scan in common."""
        order = np.argsort(np.concatenate([self.indices, others.indices]), kind="stable")
        return PlacedScans(*(np.concatenate(pair)[order] for pair in zip(self, others, strict=True)))

    def of_this_run(self) -> "PlacedScans":
        """Drop the scans of an earlier run."""
        own = self.indices >= 0
        return PlacedScans(self.indices[own], self.local[own], self.poses[own])


NO_SCANS = PlacedScans(np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 3)))


class Anchors:
    """Scans, each with its pose in a submap of the graph; 56 bytes per scan."""

    def __init__(self) -> None:
        self._numbers = array("i")  # for each scan: its index, number of its submap
        self._poses = array("d")  # for each scan: T_local_laser, T_submap_laser

    @property
    def nbytes(self) -> int:
        """Memory of all anchors, bytes."""
        return sum(part.itemsize * len(part) for part in (self._numbers, self._poses))

    def add(self, index: int, T_local_laser: FloatArray, submap: int, T_submap_laser: FloatArray) -> None:
        """Add scan ``index`` of the run."""
        self._numbers.extend((index, submap))
        self._poses.extend((*T_local_laser.tolist(), *T_submap_laser.tolist()))

    def placed(self, T_map_submap: Mapping[int, FloatArray]) -> PlacedScans:
        """Return the scans, moved with these poses (3,) of the submaps."""
        numbers, local_poses = np.array(self._numbers).reshape(-1, 2), np.array(self._poses).reshape(-1, 6)
        origins = np.array([T_map_submap[number] for number in numbers[:, 1].tolist()]).reshape(-1, 3)
        order = np.argsort(numbers[:, 0], kind="stable")
        poses = compose_poses(origins, local_poses[:, 3:])
        return PlacedScans(numbers[order, 0].astype(np.int64), local_poses[order, :3], poses[order])
