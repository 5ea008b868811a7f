"""A saved state of the method, resumed at its end or relocated to another pose in the same map.

If the graph of the map is known, a relocated robot closes loops with it, which may change the whole map; otherwise the
old map does not change.
"""

from dataclasses import dataclass

import numpy as np

from slam.config import SlamConfig
from slam.graph.closed_state import placed, uncertainty_of
from slam.graph.closure import ClosedRun
from slam.graph.known_graph import KnownGraph
from slam.graph.loop_closing import STEPPED, LoopClosing, Timing
from slam.line_slam import LineSlam
from slam.lines.learnt_noise import LearntNoise
from slam.mappers import surfel_mapper
from slam.mapping.map_uncertainty import MapUncertainty
from slam.matching.surfel_mapper import SurfelMapper
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.pose import Pose2D

RELOCATION_COVARIANCE = np.diag([0.05**2, 0.05**2, 0.05**2])
"""Standard deviations squared of x, y, theta, metres and radians, of the pose to which a robot is relocated."""


@dataclass(frozen=True, slots=True, eq=False)
class SavedSlam:
    """State of LineSlam with this project's matcher and map; the arrays are shared with it."""

    mapper: SurfelMapperState
    T_map_base: Pose2D
    """The last estimate; the start before the first scan."""
    T_odom_base: Pose2D | None
    """The odometry at the last estimate; None before the first scan."""
    T_map_mapped: Pose2D | None
    """The last estimate of a matched scan."""
    noise: LearntNoise
    """Learnt noise of the ranges."""
    graph: KnownGraph | None = None
    """Graph of the map; None if only the map is known."""


def save(slam: LineSlam, closed: ClosedRun | None = None) -> SavedSlam | None:
    """Save the state for ``resume`` and ``relocate``; None for a map that is not this project's own.

    With loop closing, the map is that of the finished run, or, before its end, the present map.
    """
    if not isinstance(slam.mapper, SurfelMapper):
        return None
    T_map_local, state = slam.T_map_local, slam.mapper.state
    if closed is not None:
        T_map_local = Pose2D.from_array(closed.T_map_local)
        state = placed(state, T_map_local, closed.map, uncertainty_of(closed))
    elif slam.loops is not None:
        state = placed(state, T_map_local, slam.loops.map, MapUncertainty())
    mapped = None if slam.T_local_mapped is None else T_map_local @ slam.T_local_mapped
    return SavedSlam(state, T_map_local @ slam.T_local_base, slam.T_odom_base, mapped, slam.noise)


def resume(config: SlamConfig, T_base_laser: Pose2D, saved: SavedSlam) -> LineSlam:
    """Continue with the next scan and odometry of the same run, as if the method had never stopped."""
    config = _in_one_map(config)
    slam = LineSlam(config, T_base_laser, saved.T_map_base)
    slam.mapper, slam.noise = surfel_mapper(config, T_base_laser, saved.mapper), saved.noise
    slam.T_odom_base, slam.T_local_mapped = saved.T_odom_base, saved.T_map_mapped
    return slam


def relocate(
    config: SlamConfig, T_base_laser: Pose2D, saved: SavedSlam, T_map_base: Pose2D, timing: Timing = STEPPED
) -> LineSlam:
    """Continue in the saved map with a robot that restarts at ``T_map_base``, with new odometry.

    ``timing`` says when loops, including those with the graph of the map, change it.
    """
    graph = saved.graph
    config = _in_one_map(config) if graph is None else config
    slam = LineSlam(config, T_base_laser, T_map_base, timing=timing)
    relocated = saved.mapper.relocated(T_map_base, RELOCATION_COVARIANCE)
    slam.mapper = surfel_mapper(config, T_base_laser, relocated, 0 if graph is None else graph.next_submap)
    slam.loops = LoopClosing.for_mapper(slam.mapper, timing, graph)
    slam.noise = saved.noise
    return slam


def _in_one_map(config: SlamConfig) -> SlamConfig:
    """Return the settings without loop closing: a map without known submaps cannot be corrected."""
    return config.model_copy(update={"loops": "never"})
