"""Compiles the hot loops of matching and of the back end in a process beside the first run on a machine."""

import gc
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Final

import numpy as np

from slam.compiled import is_cold
from slam.config import SlamConfig
from slam.graph.back_end import BackEnd
from slam.graph.closed_map import ClosedMap
from slam.graph.key_scan import KeyScan
from slam.graph.map_tracking import MapTracking
from slam.graph.wall_landmarks import wall_spans
from slam.lidars import TABLE1
from slam.lines.facets import COUNT, NY, VARIANCE, X, Y
from slam.mappers import make_mapper
from slam.mapping.free_space import count_seen_through
from slam.matching.surfel_mapper import SurfelMapper
from slam.pose import FloatArray, Pose2D

_LAPS, _KEYS = 6, 3
"""Number of submaps of the same place, and of key scans in each."""
_LAST: Final = (count_seen_through, wall_spans)
"""The hot loops that are compiled last, one of the search for loops and one of the end of a run."""


def corridor_ranges() -> FloatArray:
    """Return the ranges of TABLE1 in the middle of a corridor 2 m wide."""
    across = 1.0 / np.maximum(np.abs(np.sin(TABLE1.lidar.angles)), 1e-3)
    return np.where(across < 3.0, across, np.inf)


def match_scans(config: SlamConfig) -> None:
    """Match two key scans to a map, each as after a break, so that the functions of matching are compiled."""
    mapper, key = _mapper(config), _key_scan()
    tracking, closed = MapTracking(mapper.config, mapper.map.config), ClosedMap(mapper.map)
    for index in range(2):
        tracking.follow(replace(key, index=index, broken=True), np.zeros(3), closed.map.grid)
        closed.add(key, np.zeros(3))


def close_loops(config: SlamConfig, keys: int = _KEYS) -> None:
    """Close loops in the back end, with this many key scans in each submap of a corridor that is driven several times.

    With one key scan a submap has no walls, so that no loop is searched, and only the end of a run is compiled.
    """
    mapper, key = _mapper(config), _key_scan()
    back_end = BackEnd(mapper.config, mapper.map.config)
    for index in range(_LAPS * keys):
        T_local_laser = np.array([0.3 * (index % keys), 0.0, 0.0])
        back_end.take(replace(key, T_local_laser=T_local_laser, submaps=(index // keys,), index=index))
    back_end.finish(np.zeros(3))


@contextmanager
def compiling_beside() -> Iterator[Callable[[], object]]:
    """Compile in another process while the block runs, unless everything is compiled already; it ends with the block.

    Yields a function that waits until everything is compiled. A process that needs a function which is being compiled
    waits for that one alone.
    """
    process = _started() if any(is_cold(loop) for loop in _LAST) else None
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
