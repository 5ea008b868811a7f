"""What a search for a loop makes of the places that it found: one, two that are as good, one that says too little."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.key_scan import KeyScan
from slam.graph.loop_check import Check, KeyMatch
from slam.graph.loop_search import MOST_ANGLE, MOST_WINDOW, LoopSearch, _second_place, _window, _without
from slam.graph.submap_graph import SubmapGraph
from slam.lidars import TABLE1
from slam.matching.coarse_search import HEADING_STEP, PIXEL
from slam.pose import FloatArray, compose_poses

OWN = np.array([4.0, -2.0, 0.5])
"""Pose of the key scan by which places are compared."""
HERE = np.array([1.0, 2.0, 0.3])


def check(place: FloatArray, agreement: float) -> Check:
    match = KeyMatch(0, np.zeros(3), np.eye(3), agreement, True)
    return Check(place, [match])


def moved(x: float, y: float, turn: float) -> FloatArray:
    """The place that has the key scan so far from where HERE has it, and turned on the spot."""
    there = compose_poses(HERE, OWN) + np.array([x, y, turn])
    back = np.array([there[0], there[1], HERE[2] + turn])
    c, s = np.cos(back[2]), np.sin(back[2])
    back[:2] -= np.array([c * OWN[0] - s * OWN[1], s * OWN[0] + c * OWN[1]])
    return back


@given(st.floats(-3.0, 3.0), st.floats(0.4, 5.0))
def test_a_second_place_as_good_leaves_the_way_to_it_open(bearing: float, apart: float) -> None:
    way = np.array([np.cos(bearing), np.sin(bearing)])
    direction, turned = _second_place([check(HERE, 8.0), check(moved(*(apart * way), 0.0), 7.5)], OWN)
    assert direction == pytest.approx(way)
    assert not turned


@pytest.mark.parametrize(
    ("place", "agreement"),
    [((2.0, 0.0, 0.0), 7.0), ((0.1, 0.1, 0.0), 8.0), ((0.0, 0.0, 0.05), 8.0)],
)
def test_a_worse_or_the_same_place_leaves_nothing_open(place: tuple[float, float, float], agreement: float) -> None:
    assert _second_place([check(HERE, 8.0), check(moved(*place), agreement)], OWN) == (None, False)
    assert _second_place([check(HERE, 8.0)], OWN) == (None, False)


@pytest.mark.parametrize("turn", [0.2, -np.pi + 0.01, np.pi])
def test_a_second_place_that_is_turned_contradicts(turn: float) -> None:
    assert _second_place([check(HERE, 8.0), check(moved(0.0, 0.0, turn), 7.5)], OWN)[1]


@given(st.floats(-3.0, 3.0), st.lists(st.floats(-1.0, 1.0), min_size=9, max_size=9))
def test_nothing_is_known_any_more_along_an_open_direction(bearing: float, row: list[float]) -> None:
    """What is left is the information with that place unknown; what it says across and of the heading stays."""
    spread = np.reshape(row, (3, 3))
    information, d = spread @ spread.T + np.eye(3), np.array([np.cos(bearing), np.sin(bearing), 0.0])
    left = _without(information, d[:2])
    np.testing.assert_allclose(left @ d, 0.0, atol=1e-9)
    rest = np.array([[-d[1], d[0], 0.0], [0.0, 0.0, 1.0]])
    known = np.linalg.inv(rest @ np.linalg.inv(information) @ rest.T)
    np.testing.assert_allclose(rest @ left @ rest.T, known, atol=1e-9)
    np.testing.assert_array_equal(_without(np.zeros((3, 3)), d[:2]), 0.0)


def test_a_window_reaches_three_sigmas_but_not_beyond_its_most() -> None:
    small = _window(HERE, np.diag([0.19, 0.1, 0.05]) ** 2, 50)
    assert (small.places, small.headings) == (6, 8)  # 0.57 m and 0.15 rad, rounded up
    wide = _window(HERE, np.diag([20.0, 9.0, 0.4]) ** 2, 50)
    assert (wide.places, wide.headings) == (round(MOST_WINDOW / PIXEL), round(MOST_ANGLE / HEADING_STEP))
    around = _window(HERE, np.diag([0.5, 0.5, 2.0]) ** 2, 50)
    assert around.headings * HEADING_STEP == pytest.approx(np.pi, abs=HEADING_STEP)
    np.testing.assert_allclose(small.information, np.diag(np.array([0.19, 0.1, 0.05]) ** -2.0) / 50.0)


def test_scans_that_see_hardly_a_wall_are_not_sought() -> None:
    graph, facets = SubmapGraph(), np.array([[1.0, 0.0, 1.0, 0.0, 1e-4, 5.0, 0.0]] * 2)
    for number in range(4):
        pose = np.array([0.3 * number, 0.0, 0.0])
        graph.add(KeyScan(pose, (number // 2,), facets, np.ones(3, np.float32), TABLE1.lidar, index=number))
    search = LoopSearch(graph, LeastSquaresConfig(), SurfelMapConfig())
    for submap in graph.submaps.values():
        submap.finish(graph.keys)
    view = search.view(graph.submaps[1])
    assert search.find(view, graph.submaps[0], np.diag([0.1, 0.1, 0.05]), "odometry") is None
