"""Results of the back end: closures during a run, and the closed run at its end."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slam.graph.anchors import NO_SCANS, PlacedScans
from slam.graph.graph_size import GraphSize
from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.pose_graph import Edges
from slam.graph.refined_walls import RefinedWalls
from slam.graph.submap import Submap
from slam.lines.segments import IntArray
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, compose_poses, inverse_poses, relative_poses, wrap_angles


@dataclass(frozen=True, slots=True, eq=False)
class Closure:
    """The map after loops were closed for one submap, and the pose of the front end in it."""

    submap: int
    """Number of the submap that was searched for loops."""
    T_map_local: FloatArray
    """T_map_local (3,) at the last submap."""
    T_local_submap: FloatArray
    """Pose (3,) at which the last submap begins."""
    covariance: FloatArray
    """Covariance (3, 3) of the last submap's pose (x, y, theta) in the map frame."""
    map: SurfelMap
    """Map made of all key scans so far."""
    keys: int
    """Number of key scans, including pruned ones."""
    loops: tuple[Loop, ...]
    """Loops found since the previous closure."""
    poses: FloatArray
    """(K, 3): T_map_laser of the kept key scans."""
    indices: IntArray
    """(K,): indices of their scans in the run, below 0 for an earlier run."""
    loop_keys: IntArray
    """(M, 2): scan indices of the two key scans of each loop of the graph; see ``slam.graph.loop.loop_keys``."""


@dataclass(frozen=True, eq=False)
class ClosedRun:
    """A run after its last loop was closed and all its key scans and walls were refined together."""

    keys: tuple[KeyScan, ...]
    poses: FloatArray
    """(K, 3): T_map_laser of the key scans."""
    covariances: FloatArray
    """(K, 3, 3): covariances of the key scans, map frame."""
    map: SurfelMap
    loops: tuple[Loop, ...]
    """All loops that were found."""
    weights: FloatArray
    """(L,): weight of each loop, 0 to 1."""
    nodes: FloatArray
    """(N, 3): poses of all nodes of the graph, map frame."""
    key_nodes: IntArray
    """(K,): the node of each key scan."""
    submaps: tuple[Submap, ...]
    edges: Edges
    edge_weights: FloatArray
    """(E,): weight of each edge."""
    T_base_laser: FloatArray
    """(3,): mount of the laser."""
    walls: RefinedWalls
    """Walls seen by all key scans together."""
    wall_covariances: FloatArray
    """(M, 2, 2): covariance of offset and direction of each wall in the map; m^2, m rad, rad^2."""
    size: GraphSize
    anchors: PlacedScans = NO_SCANS
    """Scans kept of pruned submaps; the poses of the other scans of these submaps are interpolated between them."""

    @cached_property
    def indices(self) -> IntArray:
        """Indices of the key scans in the run, (K,)."""
        return np.array([key.index for key in self.keys], np.int64)

    @cached_property
    def local(self) -> FloatArray:
        """T_local_laser of the key scans, (K, 3)."""
        return np.array([key.T_local_laser for key in self.keys]).reshape(-1, 3)

    @property
    def T_map_local(self) -> FloatArray:
        """(3,): T_map_local at the last key scan."""
        return compose_poses(self.poses[-1], inverse_poses(self.local[-1]))

    def trajectory(self, T_local_base: FloatArray) -> FloatArray:
        """Return ``T_map_base`` (S, 3) of every scan of the run, from the poses of the front end, (S, 3).

        Each scan between two key scans (or anchors) is placed from both by the motion of the front end, and the two
        poses are blended.
        """
        laser = compose_poses(T_local_base, np.broadcast_to(self.T_base_laser, T_local_base.shape))
        placed = PlacedScans(self.indices, self.local, self.poses).with_others(self.anchors).of_this_run()
        indices, scans = placed.indices, np.arange(len(laser))
        before = np.clip(np.searchsorted(indices, scans, side="right") - 1, 0, len(indices) - 1)
        after = np.minimum(before + 1, len(indices) - 1)
        ahead = compose_poses(placed.poses[before], relative_poses(placed.local[before], laser))
        back = compose_poses(placed.poses[after], relative_poses(placed.local[after], laser))
        gap = np.maximum(indices[after] - indices[before], 1)
        share = np.clip((scans - indices[before]) / gap, 0.0, 1.0) * (after > before)
        blended = ahead + share[:, None] * _offsets(back, ahead)
        return compose_poses(blended, np.broadcast_to(inverse_poses(self.T_base_laser), blended.shape))


def _offsets(poses: FloatArray, others: FloatArray) -> FloatArray:
    """Return poses (S, 3) minus others, with angles within half a turn."""
    offsets = poses - others
    offsets[:, 2] = wrap_angles(offsets[:, 2])
    return offsets
