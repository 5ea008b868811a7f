"""Pruning of the graph: removed and kept key scans, and a size that does not grow with laps."""

from copy import deepcopy
from dataclasses import replace
from typing import Final

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.bench.block_log import cast_walls
from slam.config import SlamConfig
from slam.graph.anchors import Anchors
from slam.graph.back_end import BackEnd
from slam.graph.joined_edges import fused, inflated, inverted, joined
from slam.graph.key_scan import KeyScan
from slam.graph.marginals import pose_covariances
from slam.graph.pose_graph import NO_LOOP, Edge, Edges, solve_graph
from slam.graph.pruning import DELAY, Pruning
from slam.graph.submap_mapper import SubmapMapper
from slam.lidars import Lidar
from slam.line_slam import LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, compose_poses, relative_poses, stack_poses
from slam.scan import LaserScan

LIDAR: Final = Lidar(
    angle_min=-np.pi / 2, angle_increment=np.pi / 90, beams=91, range_min=0.05, range_max=8.0, scan_time=0.1
)
CORNERS: Final = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 5.0], [0.0, 5.0]])
LAPS: Final = 10


def rectangle(x: float, y: float, to_x: float, to_y: float) -> FloatArray:
    """Return the four sides of a rectangle, (4, 2, 2)."""
    corners = np.array([[x, y], [to_x, y], [to_x, to_y], [x, to_y], [x, y]])
    return np.stack([corners[:-1], corners[1:]], axis=1)


ROOMS: Final = np.concatenate([
    rectangle(-1, -1, 9, 6), rectangle(1, 1, 7, 4), rectangle(3, -1, 3.6, -0.6), rectangle(8.5, 2, 9, 2.8),
    rectangle(5, 5.5, 6.2, 6), rectangle(-1, 2, -0.6, 3),
])  # fmt: skip
SHELVES: Final = np.concatenate([rectangle(0.5, -1, 7.5, -0.6), rectangle(8.6, 0.5, 9, 4.5)])


def lap() -> list[Pose2D]:
    """Drive along the sides of CORNERS, and turn on the spot at the corners."""
    poses = []
    for side, (start, end) in enumerate(zip(CORNERS, np.roll(CORNERS, -1, axis=0), strict=True)):
        length, heading = float(np.hypot(*(end - start))), side * np.pi / 2
        poses += [
            Pose2D.from_array(np.append(start + s / length * (end - start), heading))
            for s in np.arange(0.0, length, 0.25)
        ]
        poses += [Pose2D.from_array(np.append(end, heading + turn)) for turn in np.linspace(0.0, np.pi / 2, 6)[:-1]]
    return poses


LAP: Final = lap()


class Drive:
    """Laps through the rooms, and the key scans that the front end makes; the odometry overestimates rotation."""

    def __init__(self, laps: int, changed_after: int | None = None) -> None:
        self.truth, self.keys = stack_poses(LAP * laps), list[KeyScan]()
        local: list[Pose2D] = []
        rng, wheels = np.random.default_rng(3), Pose2D()
        self.slam = slam = LineSlam(SlamConfig(), Pose2D())
        slam.loops, mapper = None, slam.mapper
        assert isinstance(mapper, SubmapMapper)
        path = LAP * laps
        for index, pose in enumerate(path):
            motion = path[max(index - 1, 0)].between(pose)
            wheels = wheels @ Pose2D(motion.x, motion.y, motion.theta + 0.01 * motion.x)
            changed = changed_after is not None and index >= changed_after * len(LAP)
            walls = np.concatenate([ROOMS, SHELVES]) if changed else ROOMS
            ranges = cast_walls(walls, pose.as_array()[None], LIDAR.angle_min, LIDAR.angle_increment, LIDAR.beams)[0]
            ranges = np.where(ranges < LIDAR.range_max, ranges + 0.01 * rng.standard_normal(LIDAR.beams), np.inf)
            local.append(slam.update(scan_of(ranges, 0.1 * index), Odometry(0.1 * index, wheels)).T_map_base)
            if mapper.key is not None:
                self.keys.append(replace(mapper.key, index=index))
        self.local = stack_poses(local)

    def back_end(self, laps: int) -> BackEnd:
        """The back end after so many laps."""
        back_end = BackEnd(self.slam.config.matching, self.slam.config.map)
        self.take(back_end, range(laps))
        return back_end

    def take(self, back_end: BackEnd, laps: range) -> None:
        """Give the back end the key scans of these laps."""
        for key in self.keys:
            if key.index // len(LAP) in laps:
                back_end.take(key)


def scan_of(ranges: FloatArray, stamp: float) -> LaserScan:
    """A scan of LIDAR."""
    return LaserScan(
        stamp, LIDAR.angle_min, LIDAR.angle_increment, LIDAR.range_min, LIDAR.range_max, ranges, 0.0, LIDAR.scan_time
    )


@pytest.fixture(scope="module")
def driven() -> Drive:
    return Drive(LAPS)


@pytest.fixture(scope="module")
def early(driven: Drive) -> BackEnd:
    """The back end after five laps."""
    return driven.back_end(5)


@pytest.fixture(scope="module")
def back_end(driven: Drive, early: BackEnd) -> BackEnd:
    """The back end after all laps."""
    late = deepcopy(early)
    driven.take(late, range(5, LAPS))
    return late


def test_five_more_laps_do_not_make_the_graph_larger(driven: Drive, early: BackEnd, back_end: BackEnd) -> None:
    first, half, late = (other.graph for other in (driven.back_end(1), early, back_end))
    assert len(late.keys) < 1.1 * len(half.keys) < 4 * len(first.keys)
    assert len(late.submaps) < len(half.submaps) + 3
    assert len(late.edges) < 1.2 * len(half.edges)
    assert len(late.loops) < 1.2 * len(half.loops)
    assert len(late.ties) < 3 * len(late.submaps)
    assert len(late.poses) == len(late.keys) + len(late.submaps)
    assert back_end._pruning.anchors.nbytes < 128 * driven.keys[-1].submaps[0]


def test_remaining_key_scans_are_renumbered(driven: Drive, back_end: BackEnd) -> None:
    graph, taken = back_end.graph, {key.index: key for key in driven.keys}
    assert graph.added_count == len(driven.keys)
    for number, (key, node) in enumerate(zip(graph.keys, graph.key_nodes, strict=True)):
        assert graph.number_of(node) == number
        assert set(key.submaps) <= set(taken[key.index].submaps)
        assert all(number in graph.submaps[name].keys for name in key.submaps)
    for submap in graph.submaps.values():
        assert all(submap.number in graph.keys[number].submaps for number in submap.keys)
    for number, loop in enumerate(graph.loops):
        assert loop.number == number
        assert {edge.first for edge in loop.edges} == {graph.submaps[loop.other].node}
        assert all(graph.number_of(edge.second) in graph.submaps[loop.submap].keys for edge in loop.edges)
    assert [edge for edge in graph.edges if edge.loop != NO_LOOP] == [e for loop in graph.loops for e in loop.edges]


def test_odometry_joins_only_key_scans_that_follow_each_other(driven: Drive, back_end: BackEnd) -> None:
    graph = back_end.graph
    after = {key.index: following.index for key, following in zip(driven.keys, driven.keys[1:], strict=False)}
    at = {node: key.index for node, key in zip(graph.key_nodes, graph.keys, strict=True)}
    joined_scans = [(at[edge.first], at[edge.second]) for edge in graph.odometry_edges()]
    kept = set(at.values())
    assert joined_scans == [(index, after[index]) for index in sorted(kept) if after.get(index) in kept]


def test_every_scan_has_a_place_in_the_graph(driven: Drive, early: BackEnd) -> None:
    closed = deepcopy(early).finish(np.zeros(3))
    assert len(closed.anchors.indices) > 0
    assert not set(closed.anchors.indices.tolist()) & set(closed.indices.tolist())
    found = closed.trajectory(driven.local[: 5 * len(LAP)])
    off = np.hypot(*(found - driven.truth[: 5 * len(LAP)])[:, :2].T)
    assert off.max() < 0.1
    assert np.sqrt(np.mean(off**2)) < 0.03


def test_kept_key_scans_do_not_move(driven: Drive, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patched:
        patched.setattr(Pruning, "prune", lambda *_: None)
        back_end = driven.back_end(5)
    graph = back_end.graph
    for _ in range(3):
        back_end.condensed.solve()
    before = {number: graph.poses[submap.node] for number, submap in graph.submaps.items()}
    for number in list(graph.submaps):
        back_end._prune(number)
    assert len(graph.submaps) < len(before) - DELAY
    for _ in range(3):
        back_end.condensed.solve()
    moved = [relative_poses(before[number], graph.poses[submap.node]) for number, submap in graph.submaps.items()]
    assert np.abs(moved).max() < 0.005


def test_without_overlap_nothing_is_pruned(driven: Drive) -> None:
    graph = driven.back_end(1).graph
    assert [key.index for key in graph.keys] == [key.index for key in driven.keys if key.index < len(LAP)]
    assert not graph.ties


def test_a_place_that_has_changed_is_kept_once_more(early: BackEnd) -> None:
    same, changed = (
        np.bincount([key.index // len(LAP) for key in other.graph.keys], minlength=5)
        for other in (early, Drive(5, changed_after=3).back_end(5))
    )
    assert changed[3] > same[3] + 10


def test_the_same_key_scans_give_the_same_graph(driven: Drive, early: BackEnd) -> None:
    one, other = early.graph, driven.back_end(5).graph
    np.testing.assert_array_equal(one.poses, other.poses)
    assert list(one.ties) == list(other.ties)


POSES = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)).map(np.array)
SPREADS = st.lists(st.floats(-1, 1), min_size=9, max_size=9).map(lambda row: np.reshape(row, (3, 3)))


def edge(first: int, second: int, measured: FloatArray, spread: FloatArray) -> Edge:
    return Edge(first, second, measured, np.linalg.inv(spread @ spread.T + 0.1 * np.eye(3)))


def covariance_of(edges: list[Edge], start: FloatArray, node: int) -> tuple[FloatArray, FloatArray]:
    """Pose (3,) and covariance (3, 3) of a node of a graph whose first node is at the origin."""
    solution = solve_graph(start, Edges.of(edges), 30.0)
    return solution.poses[node], pose_covariances(solution.poses, Edges.of(edges), solution.weights)[node]


@given(POSES, SPREADS)
@settings(max_examples=30)
def test_an_edge_inverted_twice_is_unchanged(measured: FloatArray, spread: FloatArray) -> None:
    once = edge(0, 1, measured, spread)
    twice = inverted(inverted(once))
    np.testing.assert_allclose(compose_poses(once.measured, inverted(once).measured), 0.0, atol=1e-9)
    np.testing.assert_allclose(twice.measured, once.measured, atol=1e-9)
    np.testing.assert_allclose(twice.information, once.information, rtol=1e-6, atol=1e-9)


@given(POSES, POSES, SPREADS, SPREADS)
@settings(max_examples=30)
def test_joined_edges_equal_the_marginal_of_the_graph(
    a: FloatArray, b: FloatArray, s: FloatArray, t: FloatArray
) -> None:
    first, second = edge(0, 1, a, s), edge(1, 2, b, t)
    one = joined(first, second)
    start = np.array([np.zeros(3), a, compose_poses(a, b)])
    pose, covariance = covariance_of([first, second], start, 2)
    np.testing.assert_allclose(relative_poses(pose, one.measured), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.inv(one.information), covariance, rtol=1e-6, atol=1e-8)
    back = joined(inverted(second), inverted(first))
    np.testing.assert_allclose(inverted(back).information, one.information, rtol=1e-6, atol=1e-8)


@given(POSES, SPREADS, SPREADS, POSES)
@settings(max_examples=30)
def test_a_fused_edge_has_the_information_of_both(a: FloatArray, s: FloatArray, t: FloatArray, off: FloatArray) -> None:
    first, second = edge(0, 1, a, s), edge(0, 1, a + 0.01 * off, t)
    one = fused(first, second)
    pose, covariance = covariance_of([first, second], np.array([np.zeros(3), a]), 1)
    np.testing.assert_allclose(relative_poses(pose, one.measured), 0.0, atol=1e-6)
    np.testing.assert_allclose(np.linalg.inv(one.information), covariance, rtol=1e-6, atol=1e-8)


def test_repeated_information_does_not_shrink_covariance() -> None:
    again = Edge(0, 1, np.zeros(3), np.diag([400.0, 400.0, 1e4]))
    tie, sigmas = again, np.array([0.01, 0.01, 0.002])
    for _ in range(1000):
        tie = fused(inflated(tie, sigmas), again)
    assert (0.01 < np.sqrt(np.diag(np.linalg.inv(tie.information))[:2])).all()


def test_anchors_move_with_their_submaps() -> None:
    anchors, moved = Anchors(), np.array([1.0, 2.0, np.pi / 2])
    anchors.add(9, np.array([4.0, 0.0, 0.0]), 3, np.array([1.0, 0.0, 0.0]))
    anchors.add(5, np.array([3.0, 0.0, 0.0]), 0, np.array([0.0, 1.0, 0.5]))
    placed = anchors.placed({0: np.zeros(3), 3: moved})
    np.testing.assert_array_equal(placed.indices, [5, 9])
    np.testing.assert_allclose(placed.poses, [[0.0, 1.0, 0.5], [1.0, 3.0, np.pi / 2]], atol=1e-12)
    np.testing.assert_array_equal(placed.local[:, 0], [3.0, 4.0])
