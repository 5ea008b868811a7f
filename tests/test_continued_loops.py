"""A run that goes on in the closed map of another: the two are one graph, in which loops are closed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest


from slam.config import SlamConfig
from slam.errors import InputError
from slam.files.graphs.file import read_graph, write_graph
from slam.files.graphs.key_scans import read_known_graph, write_key_scans
from slam.graph.closure import ClosedRun
from slam.graph.known_graph import KnownGraph
from slam.graph.run_graph import RunGraph
from slam.line_slam import Estimate, LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.saved_slam import SavedSlam, relocate, save
from slam.scan import LaserScan
from tests.test_loop_closing import BEARINGS, around, ranges_from

PATH = around(2.0)
HALF = len(around(0.75))
AUTO, NEVER = SlamConfig(), SlamConfig(loops="never")
Alter = Callable[[dict[str, np.ndarray]], None]


@dataclass(frozen=True)
class Driven:
    """A part of the way round, driven."""

    estimates: list[Estimate]
    closed: ClosedRun
    saved: SavedSlam
    begin: int

    @property
    def errors(self) -> FloatArray:
        local = stack_poses(estimate.T_local_base for estimate in self.estimates)
        truth = stack_poses(PATH[self.begin : self.begin + len(local)])
        return np.asarray(np.hypot(*(self.closed.trajectory(local) - truth)[:, :2].T))


def drive(slam: LineSlam, begin: int, end: int) -> list[Estimate]:
    """Wheels that turn by two degrees a metre too far, from the place where the robot is thought to be."""
    random, wheels, estimates = np.random.default_rng(begin), Pose2D(), []
    for k in range(begin, end):
        if k > begin:
            motion = PATH[k - 1].between(PATH[k])
            turn = motion.theta + np.radians(2.0) * motion.distance(Pose2D())
            wheels = wheels @ Pose2D(1.02 * motion.x, motion.y, turn)
        ranges = ranges_from(PATH[k]) + random.normal(0.0, 0.01, len(BEARINGS))
        ranges[ranges > 4.0] = np.inf
        scan = LaserScan(0.1 * k, float(BEARINGS[0]), 0.02, 0.05, 4.0, ranges)
        estimates.append(slam.update(scan, Odometry(0.1 * k, wheels)))
    return estimates


def finished(slam: LineSlam, estimates: list[Estimate], begin: int) -> Driven:
    closed = slam.finish()
    assert closed is not None
    saved = save(slam, closed)
    assert saved is not None
    return Driven(estimates, closed, replace(saved, graph=KnownGraph.of_run(closed)), begin)


def go_on(saved: SavedSlam, place: Pose2D, begin: int, end: int) -> Driven:
    slam = relocate(AUTO, Pose2D(), saved, place)
    return finished(slam, drive(slam, begin, end), begin)


def another(saved: SavedSlam) -> SavedSlam:
    """A copy of its own: a run writes into the map that it goes on in."""
    from copy import deepcopy

    return deepcopy(saved)


@cache
def first() -> Driven:
    """Three sides of the ring: nothing is seen again."""
    slam = LineSlam(AUTO, Pose2D(), PATH[0])
    return finished(slam, drive(slam, 0, HALF), 0)


@cache
def second() -> Driven:
    """The rest of two laps, in the map of the first."""
    saved = another(first().saved)
    return go_on(saved, saved.T_map_base, HALF - 1, len(PATH))


def test_a_ring_driven_in_two_runs_is_closed() -> None:
    closed, old = second().closed, first().closed
    numbers = {submap.number for submap in old.submaps}
    across = np.array([loop.other in numbers and loop.submap not in numbers for loop in closed.loops])
    assert (closed.weights[across] > 0.5).sum() >= 2
    assert np.sqrt(np.mean(second().errors ** 2)) < 0.06
    print(np.sqrt(np.mean(first().errors ** 2)), np.sqrt(np.mean(second().errors ** 2)), closed.size)


def test_the_old_part_of_the_map_moves() -> None:
    old, closed = first().closed, second().closed
    truth = stack_poses([PATH[k] for k in old.indices])
    now = closed.poses[closed.indices < 0]
    assert len(now) == len(old.poses)
    before, after = (np.hypot(*(poses - truth)[:, :2].T) for poses in (old.poses, now))
    print(before.max(), after.max())
    assert after.max() < 0.5 * before.max()


def test_a_known_graph_alone_is_the_same_map() -> None:
    known = first().saved.graph
    assert known is not None
    assert len(known.edges) + len(known.ties) == len(known.graph.edges.first)
    assert max(key.index for key in known.keys) < 0
