"""Loops that confirm or contradict each other, for a robot that drives one path twice and is lost in between."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.graph.condensed import CondensedGraph
from slam.graph.consistency import MAX_WAITING, Consistency, WaitingLoops, renumbered
from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.loop_candidates import LoopCandidates
from slam.graph.pose_graph import BREAK, NO_LOOP, Edge
from slam.graph.submap_graph import SubmapGraph
from slam.graph.surest_paths import SubmapSteps
from slam.graph.wall_candidates import WallCandidate
from slam.lidars import Lidar
from slam.pose import FloatArray, compose_poses, inverse_poses

LIDAR = Lidar(-0.5, 0.5, 3, 0.1, 9.0, 0.1)
KEYS, SUBMAPS = 5, 4
"""Key scans of a submap, a metre apart, and submaps of each of the two ways."""
JUMP = np.array([3.0, -2.0, 1.0])
"""Pose at which the front end believes the start to be when it returns there."""
JUMPS = st.builds(lambda x, y, theta: np.array([x, y, theta]), *[st.floats(-3, 3)] * 3)


def way_twice(jump: FloatArray) -> SubmapGraph:
    """Submaps 0 to 3 along a path, and 4 to 7 along the same path again, where the front end is off by ``jump``."""
    graph = SubmapGraph()
    for number in range(2 * SUBMAPS * KEYS):
        submap, x = number // KEYS, float(number % (SUBMAPS * KEYS))
        pose = np.array([x, 0.0, 0.0]) if submap < SUBMAPS else compose_poses(jump, np.array([x, 0.0, 0.0]))
        broken = number == SUBMAPS * KEYS
        graph.add(KeyScan(pose, (submap,), np.empty((0, 7)), np.ones(3, np.float32), LIDAR, broken=broken))
    return graph


def loop(graph: SubmapGraph, jump: FloatArray, submap: int, other: int, off: tuple[float, float, float]) -> Loop:
    """Return a loop between two submaps that is off the truth by (x, y, theta), metres and radians."""
    T_other_submap = compose_poses(np.array(off), inverse_poses(jump))
    node = graph.submaps[other].node
    nodes = [graph.key_nodes[key] for key in graph.submaps[submap].keys]
    edges = tuple(Edge(node, key, np.zeros(3), np.eye(3), 0) for key in nodes)
    return Loop(0, submap, other, T_other_submap, "walls", len(nodes), len(nodes), 0.7, False, edges, 0)


def steps_of(graph: SubmapGraph) -> SubmapSteps:
    return CondensedGraph(graph, 30.0).steps()


RIGHT = (0.0, 0.0, 0.0)


@settings(max_examples=30)
@given(JUMPS)
def test_two_correct_loops_agree_whatever_the_drift(jump: FloatArray) -> None:
    graph = way_twice(jump)
    first, second = (loop(graph, jump, SUBMAPS + k, k, RIGHT) for k in (1, 2))
    assert Consistency(graph, steps_of(graph), first).chi_squared(second) < 1e-6
    assert Consistency(graph, steps_of(graph), second).chi_squared(first) < 1e-6


@pytest.mark.parametrize("off", [(2.0, 0.0, 0.0), (0.0, -2.0, 0.0), (0.0, 0.0, 0.6)])
def test_a_wrong_loop_is_not_confirmed_by_a_correct_one(off: tuple[float, float, float]) -> None:
    graph = way_twice(JUMP)
    waiting = WaitingLoops(graph)
    assert waiting.confirmed(loop(graph, JUMP, 5, 1, RIGHT), steps_of(graph), []) == []
    assert waiting.confirmed(loop(graph, JUMP, 6, 2, off), steps_of(graph), []) == []


def test_a_second_loop_confirms_the_first_while_a_wrong_one_waits() -> None:
    graph = way_twice(JUMP)
    waiting = WaitingLoops(graph)
    right = [loop(graph, JUMP, SUBMAPS + k, k, RIGHT) for k in (1, 2, 3)]
    assert waiting.confirmed(right[0], steps_of(graph), []) == []
    assert waiting.confirmed(loop(graph, JUMP, 6, 1, (3.0, 0.0, np.pi)), steps_of(graph), []) == []
    assert waiting.confirmed(right[1], steps_of(graph), []) == [right[0], right[1]]
    assert waiting.confirmed(right[2], steps_of(graph), []) == []  # the others wait no longer
    assert waiting.confirmed(loop(graph, JUMP, 4, 0, RIGHT), steps_of(graph), right[:2]) != []


def test_two_loops_of_the_same_scans_count_once() -> None:
    graph = way_twice(JUMP)
    waiting = WaitingLoops(graph)
    assert waiting.confirmed(loop(graph, JUMP, 5, 1, RIGHT), steps_of(graph), []) == []
    assert waiting.confirmed(loop(graph, JUMP, 5, 2, RIGHT), steps_of(graph), []) == []


def test_loops_on_two_sides_of_a_break_are_independent() -> None:
    graph = way_twice(JUMP)
    across = Consistency(graph, steps_of(graph), loop(graph, JUMP, 5, 1, RIGHT))
    for submap, other in ((3, 0), (1, 0)):  # the path from (1, 0) over the break exceeds the limit of the search
        assert across.chi_squared(loop(graph, np.zeros(3), submap, other, RIGHT)) == np.inf


def test_a_path_is_limited_by_odometry_except_over_a_break() -> None:
    graph = way_twice(JUMP)
    condensed = CondensedGraph(graph, 30.0)
    candidates = LoopCandidates(graph, condensed)
    for submap in graph.submaps.values():
        submap.finish(graph.keys)
        candidates.add(submap)
    first, third, beyond = (graph.submaps[number] for number in (0, 2, 6))
    covariance = candidates.covariances_from(third)[first.number]
    for off, plausible in (((0.0, 0.0, 0.0), True), ((0.5, 0.0, 0.0), True), ((9.0, 0.0, 0.0), False)):
        candidate = WallCandidate(1.0, first, np.array(off))
        assert candidates.is_plausible(candidate, third, covariance) == plausible
        assert candidates.is_plausible(candidate, beyond, covariance)
    assert not candidates.is_out_of_reach(third, first, covariance)
    assert candidates.is_out_of_reach(beyond, first, covariance)


def test_odometry_over_a_break_has_a_large_covariance() -> None:
    graph = way_twice(JUMP)
    information = {edge.loop: edge.information for edge in graph.odometry_edges()}
    assert [edge.loop for edge in graph.odometry_edges()].count(BREAK) == 1
    assert np.trace(information[BREAK]) < 0.1 * np.trace(information[NO_LOOP])


def test_the_number_of_waiting_loops_is_limited() -> None:
    graph = way_twice(JUMP)
    waiting = WaitingLoops(graph)
    right = loop(graph, JUMP, 5, 1, RIGHT)
    waiting.confirmed(right, steps_of(graph), [])
    for _ in range(MAX_WAITING):
        waiting.confirmed(loop(graph, JUMP, 5, 1, (5.0, 0.0, 0.0)), steps_of(graph), [])
    assert waiting.confirmed(loop(graph, JUMP, 6, 2, RIGHT), steps_of(graph), []) == []


def test_edges_are_renumbered() -> None:
    graph = way_twice(JUMP)
    other = renumbered(loop(graph, JUMP, 5, 1, RIGHT), 7)
    assert other.number == 7
    assert {edge.loop for edge in other.edges} == {7}
