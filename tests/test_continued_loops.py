"""A run that goes on in the closed map of another: the two are one graph, in which loops are closed."""

from collections.abc import Callable
from copy import deepcopy
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


def test_the_end_of_the_old_part_moves_to_where_it_is() -> None:
    old, closed = first().closed, second().closed
    truth, now = stack_poses([PATH[k] for k in old.indices]), closed.poses[closed.indices < 0]
    assert len(now) == len(old.poses)
    before, after = (np.hypot(*(poses - truth)[-20:, :2].T).mean() for poses in (old.poses, now))
    assert after < before


def test_two_runs_are_hardly_worse_than_one() -> None:
    slam = LineSlam(AUTO, Pose2D(), PATH[0])
    whole = finished(slam, drive(slam, 0, len(PATH)), 0)
    one, two = np.sqrt(np.mean(whole.errors[HALF:] ** 2)), np.sqrt(np.mean(second().errors ** 2))
    assert two < 1.5 * one
    assert abs(len(second().closed.map) - len(whole.closed.map)) < 0.1 * len(whole.closed.map)


def test_the_same_place_again_and_again_keeps_its_size() -> None:
    saved, sizes, lap = second().saved, list[int](), len(around(1.0))
    for _ in range(2):
        driven = go_on(another(saved), PATH[0], 0, lap)
        assert np.sqrt(np.mean(driven.errors**2)) < 0.1
        saved = driven.saved
        sizes.append(driven.closed.size.keys)
    assert sizes[-1] <= 1.05 * sizes[0], sizes


def test_the_pose_is_known_before_any_loop_is_closed() -> None:
    place = PATH[HALF] @ Pose2D(0.04, 0.04, 0.03)
    slam = relocate(AUTO, Pose2D(), another(first().saved), place)
    estimates = drive(slam, HALF, HALF + 3)
    assert all(estimate.closure is None for estimate in estimates)
    assert estimates[-1].T_map_base.distance(PATH[HALF + 2]) < 0.15
    assert len(slam.points) >= len(first().saved.mapper.map)


def test_without_loops_or_a_graph_the_map_stays() -> None:
    bare = replace(first().saved, graph=None)
    slams = [
        relocate(NEVER, Pose2D(), another(first().saved), PATH[HALF]),
        relocate(AUTO, Pose2D(), another(bare), PATH[HALF]),
    ]
    one, other = (drive(slam, HALF, HALF + 20) for slam in slams)
    assert all(slam.loops is None and slam.finish() is None for slam in slams)
    assert stack_poses(e.T_map_base for e in one).tolist() == stack_poses(e.T_map_base for e in other).tolist()


def written(folder: Path) -> tuple[Path, RunGraph]:
    closed = second().closed
    write_graph(folder / "graph.json", RunGraph.of(closed))
    write_key_scans(folder / "key_scans.npz", closed.keys)
    return folder / "key_scans.npz", read_graph(folder / "graph.json")


def test_a_known_graph_is_read_as_it_was_written(tmp_path: Path) -> None:
    read, kept = read_known_graph(*written(tmp_path)), second().saved.graph
    assert kept is not None
    assert len(read.keys) == len(kept.keys)
    for one, other in zip(read.keys, kept.keys, strict=True):
        assert (one.index, one.submaps, one.lidar, one.share) == (other.index, other.submaps, other.lidar, other.share)
        for name in ("T_local_laser", "facets", "ranges", "information", "wheels"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert len(read.edges) + len(read.ties) == len(read.graph.edges.first)
    assert max(key.index for key in read.keys) < 0


def _one_less(arrays: dict[str, np.ndarray]) -> None:
    arrays["share"] = arrays["share"][1:]


def _more_beams(arrays: dict[str, np.ndarray]) -> None:
    arrays["beams"][0] += 1


def _later(arrays: dict[str, np.ndarray]) -> None:
    arrays["version"] = np.array(2)


def _objects(arrays: dict[str, np.ndarray]) -> None:
    arrays["share"] = np.array([{}], dtype=object)


@pytest.mark.parametrize(
    ("alter", "complaint"),
    [
        (_one_less, "share: has shape"),
        (_more_beams, "ranges: has shape"),
        (_later, "version"),
        (_objects, "no key scans"),
    ],
)
def test_key_scans_that_are_wrong_are_refused(alter: Alter, complaint: str, tmp_path: Path) -> None:
    path, graph = written(tmp_path)
    with np.load(path) as file:
        arrays = dict(file)
    alter(arrays)
    np.savez(path, **arrays)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=complaint):
        read_known_graph(path, graph)
