"""State, views and rewards of N robots, as arrays. SI units, radians."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.batch.worlds import Timing, Worlds
from sim.records import BASE
from slam.compiled import compiled
from slam.pose import FloatArray


class Robots(NamedTuple):
    """State of N robots, each in its own episode."""

    base: NDArray[Any]
    """(N,): the records BASE of the robots."""
    world: NDArray[np.int64]
    walked: FloatArray
    """(N, P, 2): metres that each person has walked, and the remaining rest, seconds."""
    people: FloatArray
    """(N, P, 2): positions of the people."""
    legs: FloatArray
    """(N, P, 2, 2): positions of their legs."""
    waypoint: NDArray[np.int64]
    """(N,): index of the next way-point."""
    left: FloatArray
    """(N,): remaining length of the route, metres."""
    turns: NDArray[np.int64]
    """(N,): turns of the lidar since the episode began."""
    cells: NDArray[np.uint8]
    """(N, rows, columns): occupancy grids, large enough for every world; (N, 0, 0) if nothing needs them."""


class BatchObservation(NamedTuple):
    """Observations of N robots in one step: views, contacts, progress; a view that is not requested has no rows."""

    scan: NDArray[np.float32]
    """(N, B): ranges; ``range_max`` without an echo, 0 where something is too close."""
    odometry: NDArray[np.float32]
    """(N, 5): x, y, theta, v, omega."""
    goal: NDArray[np.float32]
    """(N, 2): distance and bearing of the next way-point, or x and y; 0 at the end."""
    map: NDArray[np.uint8]
    """(N, 1, n, n)."""
    pose: FloatArray
    """(N, 3): ``T_map_base`` when the first beam fired."""
    gained: FloatArray
    """(N, 2): metres of the route, and newly seen cells."""
    collided: NDArray[np.bool_]
    stalled: NDArray[np.bool_]
    arrived: NDArray[np.bool_]
    late: NDArray[np.bool_]
    """(N,): True if the time is over."""
    applied: FloatArray
    """(N, 2): the command within the limits."""
    ranges: FloatArray
    """(N, B): ranges as the lidar measured them, for SLAM; (0, B) without SLAM."""
    turns: FloatArray
    """(N, 2): number of beams of this turn, and the offset of its first bearing from that of the lidar's model."""


class Scratch(NamedTuple):
    """Scratch arrays of one thread, which all of its robots use in turn."""

    rays: FloatArray
    """(5 B,): rays of up to B beams."""
    ranges: FloatArray
    """(B,): ranges of the beams."""
    numbers: FloatArray
    """(3 B,): random numbers for the ranges."""
    bearings: FloatArray
    """(B,): bearings of the beams, if they vary."""
    beams: FloatArray
    """(2 B,): unit vectors of the beams, if they vary."""
    path: FloatArray
    """(S, 3): poses of the base before and after each control step."""
    legs: FloatArray
    """(S, 2 P, 2): positions of the legs at the same times."""
    echoes: NDArray[np.bool_]
    """(B,)."""


def make_robots(count: int, worlds: Worlds, with_grids: bool) -> Robots:
    """Make the state of ``count`` robots, which have no position yet."""
    rows, columns = worlds.grids.max(axis=0) if with_grids else (0, 0)
    people = worlds.crowd.starts.shape[1]
    return Robots(
        np.zeros(count, BASE), np.zeros(count, np.int64), np.zeros((count, people, 2)), np.zeros((count, people, 2)),
        np.zeros((count, people, 2, 2)), np.zeros(count, np.int64), np.zeros(count), np.zeros(count, np.int64),
        np.zeros((count, rows, columns), np.uint8),
    )  # fmt: skip


@compiled
def make_scratch(worlds: Worlds, timing: Timing) -> Scratch:
    """Make the arrays for any turn of the lidar in any of these worlds."""
    beams, people = worlds.bearings.shape[1] + timing.beams_vary, worlds.crowd.starts.shape[1]
    controls = max(timing.controls_before, timing.controls_in_sweep)
    return Scratch(
        np.empty(5 * beams), np.empty(beams), np.empty(3 * beams), np.empty(beams), np.empty(2 * beams),
        np.empty((controls + 1, 3)), np.empty((controls + 1, 2 * people, 2)), np.empty(beams, np.bool_),
    )  # fmt: skip


def make_observation(
    count: int, worlds: Worlds, timing: Timing, views: tuple[str, ...], map_cells: int
) -> BatchObservation:
    """Make new arrays for ``count`` robots; the view ``ranges`` is the input of SLAM."""
    rows = {name: count if name in views else 0 for name in ("odometry", "goal", "map", "ranges")}
    beams = worlds.bearings.shape[1]
    collided, stalled, arrived, late = np.zeros((4, count), np.bool_)
    return BatchObservation(
        np.empty((count, beams), np.float32), np.empty((rows["odometry"], 5), np.float32),
        np.empty((rows["goal"], 2), np.float32), np.empty((rows["map"], 1, map_cells, map_cells), np.uint8),
        np.empty((count, 3)), np.zeros((count, 2)),
        collided, stalled, arrived, late, np.empty((count, 2)),
        np.empty((rows["ranges"], beams + timing.beams_vary)), np.empty((rows["ranges"], 2)),
    )  # fmt: skip
