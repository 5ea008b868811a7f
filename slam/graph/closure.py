"""Results of the back end, as the front end takes them over, and as they stand at the end of a run."""

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
    """The map after loops were closed for one submap, and where the front end is in it."""

    submap: int
    """Number of the submap for which they were sought."""
    T_map_local: FloatArray
    """(3,), as the last submap has it."""
    T_local_submap: FloatArray
    """(3,): where the last submap begins ..."""
    covariance: FloatArray
    """... and the covariance (3, 3) of its place, x, y, theta, map frame."""
    map: SurfelMap
    """All key scans until then."""
    keys: int
    """Number of them, those counted that were pruned."""
    loops: tuple[Loop, ...]
    """Those that were found since the closure before."""
    poses: FloatArray
    """(K, 3): T_map_laser of the key scans that are kept."""
    indices: IntArray
    """(K,): their numbers in the run, below 0 for those of an earlier one."""
    loop_keys: IntArray
    """(M, 2): numbers of two of them for each loop of the graph, see ``loop_keys``."""


@dataclass(frozen=True, eq=False)
class ClosedRun:
    """A run after its last loop was closed and all its key scans and walls were refined together."""

    keys: tuple[KeyScan, ...]
    poses: FloatArray
    """(K, 3): T_map_laser of the key scans ..."""
    covariances: FloatArray
    """... and the covariance (K, 3, 3) of each, map frame."""
    map: SurfelMap
    loops: tuple[Loop, ...]
    """All that were found."""
    weights: FloatArray
    """(L,): how far each of them is believed, 0 to 1."""
    nodes: FloatArray
    """(N, 3): poses of all nodes of the graph, map frame."""
    key_nodes: IntArray
    """(K,): the node of each key scan."""
    submaps: tuple[Submap, ...]
    edges: Edges
    edge_weights: FloatArray
    """(E,)."""
    T_base_laser: FloatArray
    """(3,)."""
    walls: RefinedWalls
    """The walls that all key scans together see ..."""
    wall_covariances: FloatArray
    """... and the covariance (M, 2, 2) of the offset and the direction of each in the map; m^2, m rad, rad^2."""
    size: GraphSize
    anchors: PlacedScans = NO_SCANS
    """Scans of submaps that were pruned, between which the others of these lie."""

    @cached_property
    def indices(self) -> IntArray:
        """Numbers of the key scans in the run, (K,)."""
        return np.array([key.index for key in self.keys], np.int64)

    @cached_property
    def local(self) -> FloatArray:
        """T_local_laser of the key scans, (K, 3)."""
        return np.array([key.T_local_laser for key in self.keys]).reshape(-1, 3)

    @property
    def T_map_local(self) -> FloatArray:
        """(3,): where the last key scan puts the frame of the front end."""
        return compose_poses(self.poses[-1], inverse_poses(self.local[-1]))

    def trajectory(self, T_local_base: FloatArray) -> FloatArray:
        """``T_map_base`` (S, 3) of every scan of the run, for what the front end had, (S, 3).

        Between two key scans, or anchors, the motion of the front end is joined to both, and blended.
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
    """Poses (S, 3) less others, the angles within half a turn."""
    offsets = poses - others
    offsets[:, 2] = wrap_angles(offsets[:, 2])
    return offsets
