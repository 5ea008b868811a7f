"""Loops with an unconstrained direction, as in a corridor: along it the graph determines their pose."""

from dataclasses import replace

import numpy as np

from slam.graph.loop import Loop
from slam.graph.single_poses import between, composed
from slam.graph.submap_graph import SubmapGraph
from slam.pose import FloatArray


def completed_by_graph(loop: Loop, graph: SubmapGraph) -> Loop:
    """Return the loop, moved along its unconstrained direction to where the solved graph has it.

    A loop without an unconstrained direction is unchanged.
    """
    if not loop.ambiguous or not loop.edges:
        return loop
    other, submap = graph.submaps[loop.other], graph.submaps[loop.submap]
    direction = _open_direction(loop)
    found = [between(graph.poses[edge.first], graph.poses[edge.second]) for edge in loop.edges]
    edges = tuple(
        edge._replace(measured=_moved(edge.measured, pose, direction))
        for edge, pose in zip(loop.edges, found, strict=True)
    )
    c, s = np.cos(other.T_local_submap[2]), np.sin(other.T_local_submap[2])
    local_direction = np.array([c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]])
    thought = composed(loop.T_other_submap, submap.T_local_submap)
    there = composed(between(graph.correction(other), graph.correction(submap)), submap.T_local_submap)
    shift = _moved(thought, there, local_direction) - thought
    return replace(loop, T_other_submap=loop.T_other_submap + shift, edges=edges)


def _open_direction(loop: Loop) -> FloatArray:
    """Return the direction (2,), axes of the other submap's node, that its edges constrain least."""
    information = np.sum([edge.information[:2, :2] for edge in loop.edges], axis=0)
    return np.asarray(np.linalg.eigh(information)[1][:, 0])


def _moved(pose: FloatArray, found: FloatArray, direction: FloatArray) -> FloatArray:
    """Move a pose (3,) along a direction (2,) to the point nearest to where it was found (3,)."""
    moved = pose.copy()
    moved[:2] += ((found - pose)[:2] @ direction) * direction
    return moved
