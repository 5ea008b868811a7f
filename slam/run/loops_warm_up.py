"""Compiles the hot loops of matching and of the back end in a process beside the first run on a machine."""

import gc
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from slam.compiled import is_cold
from slam.config import SlamConfig
from slam.graph.back_end import BackEnd
from slam.graph.closed_map import ClosedMap
from slam.graph.joint_refinement import refine
from slam.graph.key_scan import KeyScan
from slam.graph.map_tracking import MapTracking
from slam.graph.pose_graph import Edge, Edges
from slam.graph.wall_landmarks import wall_spans
from slam.lidars import TABLE1
from slam.lines.facets import COUNT, NY, VARIANCE, X, Y
from slam.mappers import make_mapper
from slam.matching.surfel_mapper import SurfelMapper
from slam.pose import FloatArray, Pose2D

_LAPS, _KEYS = 6, 3
"""Number of submaps of the same place, and of key scans in each."""


def corridor_ranges() -> FloatArray:
    """Return the ranges of TABLE1 in the middle of a corridor 2 m wide."""
    across = 1.0 / np.maximum(np.abs(np.sin(TABLE1.lidar.angles)), 1e-3)
    return np.where(across < 3.0, across, np.inf)


def match_scans(config: SlamConfig) -> None:
    """Match key scans to a map, after a break too: what every scan needs once its lines are known."""
    mapper, key = _mapper(config), _key_scan()
    tracking, closed = MapTracking(mapper.config, mapper.map.config), ClosedMap(mapper.map)
    for index in range(2):
        tracking.follow(replace(key, index=index, broken=True), np.zeros(3), closed.map.grid)
        closed.add(key, np.zeros(3))


def close_loops(config: SlamConfig) -> None:
    """Close loops in the back end, with key scans of a corridor that is driven along several times."""
    mapper = _mapper(config)
    back_end, key = BackEnd(mapper.config, mapper.map.config), _key_scan()
    for index in range(_LAPS * _KEYS):
        T_local_laser = np.array([0.3 * (index % _KEYS), 0.0, 0.0])
        back_end.take(replace(key, T_local_laser=T_local_laser, submaps=(index // _KEYS,), index=index))
    back_end.finish(np.zeros(3))


def refine_walls() -> None:
    """Refine key scans of the corridor and its walls, which the back end does last."""
    facets, poses, moved = _key_scan().facets, np.array([[0.3 * k, 0.0, 0.0] for k in range(3)]), [0.3, 0.0, 0.0]
    edges = Edges.of(Edge(k, k + 1, np.array(moved), 1e4 * np.eye(3)) for k in range(2))
    refine(poses, edges, np.ones(2), [facets] * 3, np.arange(3))


@contextmanager
def compiling_beside() -> Iterator[Callable[[], object]]:
    """Compile in another process while the block runs, before all is compiled on this machine; ends with the block.

    Yields a function that waits until everything is compiled. A process that needs a function which is being compiled
    waits for that one alone.
    """
    process = _started() if is_cold(wall_spans) else None
    try:
        yield _at_once if process is None else process.wait
    finally:
        if process is not None:
            process.kill()
            process.wait()


def _at_once() -> None: ...


def _started() -> "subprocess.Popen[bytes] | None":
    """Start the process; None if that is impossible: then this process compiles."""
    command, nothing = [sys.executable, "-m", "slam.run.loops_warm_up"], subprocess.DEVNULL
    try:
        return subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=nothing)
    except OSError:
        return None


def _mapper(config: SlamConfig) -> SurfelMapper:
    mapper = make_mapper(config, Pose2D(), 0)
    assert isinstance(mapper, SurfelMapper)
    return mapper


def _key_scan() -> KeyScan:
    """Make a key scan like those of the front end: the walls of the corridor in facets of 0.2 m."""
    along = np.arange(-1.6, 1.7, 0.2)
    facets = np.zeros((2 * len(along), 7))
    facets[:, X] = np.tile(along, 2)
    facets[:, Y] = facets[:, NY] = np.repeat([-1.0, 1.0], len(along))
    facets[:, VARIANCE], facets[:, COUNT] = 1e-5, 5.0
    ranges, lidar = corridor_ranges().astype(np.float32), TABLE1.lidar
    return KeyScan(
        np.zeros(3), (0,), facets, ranges, lidar, lidar.angles.astype(np.float32), information=1e4 * np.eye(3)
    )


if __name__ == "__main__":
    gc.disable()  # the process ends before its garbage matters
    match_scans(SlamConfig())
    close_loops(SlamConfig())
    gc.freeze()
