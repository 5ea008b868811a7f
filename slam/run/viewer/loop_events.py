"""Closed loops in a viewer: their lines, the corrected path, and their texts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from slam.graph.closure import Closure
from slam.graph.loop import Loop
from slam.graph.run_graph import RunGraph
from slam.pose import FloatArray, Pose2D


@dataclass(frozen=True, slots=True, eq=False)
class LoopsShown:
    """Path and loops after loop closing; metres, map frame."""

    path: FloatArray
    """(K, 2): path."""
    loops: FloatArray
    """(L, 2, 2): loops, from where a place was seen again to where it was seen before."""
    doubted: FloatArray
    """(M, 2, 2): the same for loops that are not accepted."""

    @classmethod
    def of_closure(cls, closure: Closure, laser_to_base: Pose2D) -> Self:
        """Return path and loops of a closure; until the end all of them count as accepted."""
        poses = np.array([(Pose2D.from_array(pose) @ laser_to_base).translation for pose in closure.poses])
        return cls(poses, poses[closure.loop_keys], np.empty((0, 2, 2)))

    @classmethod
    def of_graph(cls, graph: RunGraph, poses: FloatArray, until: int | None = None) -> Self:
        """Return all loops of a run, or those found up to a scan, between the poses (S, 3) of all scans."""
        found = np.array([until is None or loop.scan <= until for loop in graph.loops], np.bool_)
        ends = graph.loop_ends(poses)
        path = poses[:, :2] if until is None else poses[:0, :2]
        return cls(path, ends[found & graph.believed], ends[found & ~graph.believed])


def closure_text(loops: Sequence[Loop], before: Pose2D, after: Pose2D) -> str:
    """Return a text on a closure, with its loop and the motion of the pose.

    An example: loop closed: submap 41 found in submap 3, 14 of 15 scans agree, map moved by 0.42 m.
    """
    moved = f"map moved by {before.distance(after):.2f} m"
    if not loops:
        return f"loop closed: {moved}"
    surest = max(loops, key=lambda loop: loop.agreeing)
    more = f", with {len(loops) - 1} more" if len(loops) > 1 else ""
    return f"loop closed: {surest.text}{more}, {moved}"


def end_text(graph: RunGraph, before: Pose2D, after: Pose2D) -> str:
    """Return a text on the closure of the whole run, with the motion of the robot's pose."""
    believed, moved = int(graph.believed.sum()), f"{before.distance(after):.2f} m"
    return f"all loops closed at the end: {believed} of {len(graph.loops)} believed, the robot moved by {moved}"
