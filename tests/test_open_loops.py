"""Loops with an open direction after the graph is solved; edges over breaks."""

from dataclasses import replace

import numpy as np
import pytest

from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.open_loops import completed_by_graph
from slam.graph.pose_graph import BREAK, NO_LOOP, Edge, Edges
from slam.graph.single_poses import between, composed
from slam.graph.submap_graph import SubmapGraph
from slam.lidars import TABLE1

BESIDE = np.array([0.0, 0.02, 0.0])
ALONG_OPEN = np.diag([0.0, 1e4, 1e5])
"""Information of an edge that leaves x open, axes of the other submap."""


def graph_with(off: float) -> tuple[SubmapGraph, Loop]:
    """Two submaps of one key scan each, 5 m apart along x, and a loop between them. The loop measures the second submap
    ``off`` metres farther along x, and 2 cm to the left."""
    graph = SubmapGraph()
    for number, x in enumerate((0.0, 5.0)):
        pose = np.array([x, 1.0, 0.4])
        graph.add(KeyScan(pose, (number,), np.empty((0, 7)), np.empty(0, np.float32), TABLE1.lidar, index=number))
    first, second = graph.submaps[0], graph.submaps[1]
    measured = between(first.T_local_submap, second.T_local_submap) + np.array([off, 0.02, 0.0])
    edge = Edge(first.node, graph.key_nodes[1], measured, ALONG_OPEN, 0)
    seen = composed(first.T_local_submap, measured)
    T_other_submap = composed(seen, between(second.T_local_submap, np.zeros(3)))
    return graph, Loop(0, 1, 0, T_other_submap, "odometry", 1, 1, 1.0, True, (edge,), 1)


@pytest.mark.parametrize("off", [0.0, 0.7, -3.0])
def test_an_open_direction_follows_the_graph(off: float) -> None:
    graph, loop = graph_with(off)
    found = completed_by_graph(loop, graph)
    known = between(graph.submaps[0].T_local_submap, graph.submaps[1].T_local_submap)
    np.testing.assert_allclose(found.edges[0].measured, known + BESIDE, atol=1e-9)
    place = composed(found.T_other_submap, graph.submaps[1].T_local_submap)
    expected = composed(graph.submaps[0].T_local_submap, known + BESIDE)
    np.testing.assert_allclose(place, expected, atol=1e-9)


def test_a_loop_without_an_open_direction_is_unchanged() -> None:
    graph, loop = graph_with(0.7)
    sure = replace(loop, ambiguous=False)
    assert completed_by_graph(sure, graph) is sure


def test_edges_over_breaks_become_ordinary_edges() -> None:
    information = np.diag([4.0, 4.0, 4.0])
    edges = Edges.of([Edge(0, 1, np.zeros(3), information, loop) for loop in (NO_LOOP, BREAK, 3)])
    found, weights = edges.settled(np.array([1.0, 0.25, 0.5]))
    assert found.loop.tolist() == [NO_LOOP, NO_LOOP, 3]
    assert weights.tolist() == [1.0, 1.0, 0.5]
    np.testing.assert_allclose(found.information[:, 0, 0], [4.0, 1.0, 4.0])
