"""The search for a loop: rooms that are found again, and the result if two places fit equally well."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.bench.block_log import cast_walls
from slam.config import ChiSquareConfig, LeastSquaresConfig, SurfelMapConfig
from slam.graph.condensed import CondensedGraph
from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.loop_check import Check, KeyMatch
from slam.graph.loop_finder import LoopFinder
from slam.graph.loop_search import MAX_ANGLE, MAX_WINDOW, LoopSearch, _second_place, _window, _without
from slam.graph.submap_graph import SubmapGraph
from slam.lidars import Lidar
from slam.lines.chi_square import segments_by_chi_square
from slam.lines.facets import facets_of
from slam.lines.learnt_noise import ASSUMED
from slam.matching.coarse_search import HEADING_STEP, PIXEL
from slam.pose import FloatArray, compose_poses
from slam.scan import LaserScan

OWN = np.array([4.0, -2.0, 0.5])
"""Pose of the key scan by which places are compared."""
HERE = np.array([1.0, 2.0, 0.3])


def check(place: FloatArray, agreement: float) -> Check:
    match = KeyMatch(0, np.zeros(3), np.eye(3), agreement, True)
    return Check(place, [match])


def moved(x: float, y: float, turn: float) -> FloatArray:
    """Return the place at which the key scan is shifted by (x, y) from its pose at HERE, and turned on the spot."""
    there = compose_poses(HERE, OWN) + np.array([x, y, turn])
    back = np.array([there[0], there[1], HERE[2] + turn])
    c, s = np.cos(back[2]), np.sin(back[2])
    back[:2] -= np.array([c * OWN[0] - s * OWN[1], s * OWN[0] + c * OWN[1]])
    return back


@given(st.floats(-3.0, 3.0), st.floats(0.4, 5.0))
def test_an_equal_second_place_leaves_a_direction_open(bearing: float, apart: float) -> None:
    way = np.array([np.cos(bearing), np.sin(bearing)])
    direction, turned = _second_place([check(HERE, 8.0), check(moved(apart * way[0], apart * way[1], 0.0), 7.5)], OWN)
    assert direction == pytest.approx(way)
    assert not turned


@pytest.mark.parametrize(
    ("place", "agreement"),
    [((2.0, 0.0, 0.0), 7.0), ((0.1, 0.1, 0.0), 8.0), ((0.0, 0.0, 0.05), 8.0)],
)
def test_a_worse_or_equal_place_leaves_no_direction_open(place: tuple[float, float, float], agreement: float) -> None:
    assert _second_place([check(HERE, 8.0), check(moved(*place), agreement)], OWN) == (None, False)
    assert _second_place([check(HERE, 8.0)], OWN) == (None, False)


@pytest.mark.parametrize("turn", [0.2, -np.pi + 0.01, np.pi])
def test_a_rotated_second_place_is_a_contradiction(turn: float) -> None:
    assert _second_place([check(HERE, 8.0), check(moved(0.0, 0.0, turn), 7.5)], OWN)[1]


@given(st.floats(-3.0, 3.0), st.lists(st.floats(-1.0, 1.0), min_size=9, max_size=9))
def test_an_open_direction_has_no_information(bearing: float, row: list[float]) -> None:
    """The other direction and the heading keep the information that they have if the open direction is unknown."""
    spread = np.reshape(row, (3, 3))
    information, d = spread @ spread.T + np.eye(3), np.array([np.cos(bearing), np.sin(bearing), 0.0])
    left = _without(information, d[:2])
    np.testing.assert_allclose(left @ d, 0.0, atol=1e-9)
    rest = np.array([[-d[1], d[0], 0.0], [0.0, 0.0, 1.0]])
    known = np.linalg.inv(rest @ np.linalg.inv(information) @ rest.T)
    np.testing.assert_allclose(rest @ left @ rest.T, known, atol=1e-9)
    np.testing.assert_array_equal(_without(np.zeros((3, 3)), d[:2]), 0.0)


def test_a_window_is_three_sigmas_up_to_its_maximum() -> None:
    small = _window(HERE, np.diag([0.19, 0.1, 0.05]) ** 2, 50)
    assert (small.half_width, small.half_headings) == (6, 8)  # 0.57 m and 0.15 rad, rounded up
    wide = _window(HERE, np.diag([20.0, 9.0, 0.4]) ** 2, 50)
    assert (wide.half_width, wide.half_headings) == (round(MAX_WINDOW / PIXEL), round(MAX_ANGLE / HEADING_STEP))
    turned = _window(HERE, np.diag([0.5, 0.5, 0.6]) ** 2, 50)
    assert turned.half_headings == 90  # three sigmas, more than MAX_ANGLE
    around = _window(HERE, np.diag([0.5, 0.5, 2.0]) ** 2, 50)
    assert around.half_headings * HEADING_STEP == pytest.approx(np.pi, abs=HEADING_STEP)
    np.testing.assert_allclose(small.information, np.diag(np.array([0.19, 0.1, 0.05]) ** -2.0) / 50.0)


def outline(*corners: tuple[float, float]) -> FloatArray:
    """The walls (W, 2, 2) between these corners, and back to the first."""
    return np.stack([np.array(corners), np.roll(np.array(corners), -1, axis=0)], axis=1)


def twice_in(walls: FloatArray, drift: FloatArray, broken: bool = False) -> SubmapGraph:
    """Two submaps, finished, of three scans each in the middle of a room; ``local`` has drifted between the two."""
    graph, lidar = SubmapGraph(), Lidar(-np.pi, np.pi / 180, 360, 0.05, 20.0, 0.1)
    for number in range(6):
        place = np.array([0.3 * (number % 3), 0.1, 0.2])
        ranges = cast_walls(walls, place[None], lidar.angle_min, lidar.angle_increment, lidar.beams)[0]
        scan = LaserScan(0.0, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max, ranges)
        facets = facets_of(scan, segments_by_chi_square(scan, ChiSquareConfig(), ASSUMED), 0.2)
        local = compose_poses(drift, place) if number >= 3 else place
        readings, breaks = ranges.astype(np.float32), broken and number == 3
        graph.add(KeyScan(local, (number // 3,), facets, readings, lidar, index=number, broken=breaks))
    for submap in graph.submaps.values():
        submap.finish(graph.keys)
    return graph


def found_in(graph: SubmapGraph, covariance: FloatArray) -> Loop | None:
    search = LoopSearch(graph, LeastSquaresConfig(), SurfelMapConfig())
    return search.find(search.view(graph.submaps[1]), graph.submaps[0], covariance, "odometry")


L_ROOM = outline((-3.0, -2.0), (4.0, -2.0), (4.0, 1.0), (1.5, 1.0), (1.5, 4.0), (-3.0, 4.0))
HALL = outline((-4.0, -2.5), (4.0, -2.5), (4.0, 2.5), (-4.0, 2.5))
DRIFT = np.array([0.0, -0.3, 0.15])
KNOWN, ANY_HEADING = np.diag([0.3, 0.3, 0.1]) ** 2, np.diag([0.5, 0.5, 2.0]) ** 2


@pytest.mark.parametrize("covariance", [KNOWN, ANY_HEADING])
def test_a_room_is_recognized_after_a_drift(covariance: FloatArray) -> None:
    loop = found_in(twice_in(L_ROOM, DRIFT), covariance)
    assert loop is not None
    assert compose_poses(loop.T_other_submap, DRIFT) == pytest.approx(np.zeros(3), abs=0.01)
    assert (loop.submap, loop.other, loop.agreeing) == (1, 0, 3)


def test_a_symmetric_hall_is_found_if_its_heading_is_known() -> None:
    graph = twice_in(HALL, DRIFT)
    assert found_in(graph, ANY_HEADING) is None
    loop = found_in(graph, KNOWN)
    assert loop is not None
    off = compose_poses(loop.T_other_submap, DRIFT)
    assert off[1:] == pytest.approx(np.zeros(2), abs=0.01)  # along the hall, x may stay at the prior


def test_another_room_gives_no_loop() -> None:
    graph = twice_in(L_ROOM, DRIFT)
    graph.keys[3:] = twice_in(outline((-2.0, -9.0), (2.0, -9.0), (1.0, 5.0), (-2.0, 5.0)), DRIFT).keys[3:]
    assert found_in(graph, KNOWN) is None


def test_scans_with_few_walls_are_not_searched_for() -> None:
    graph = twice_in(outline((1.0, -0.1), (1.0, 0.1)), DRIFT)
    assert found_in(graph, KNOWN) is None


def test_without_a_match_after_a_break_no_edge_is_added() -> None:
    """The robot was carried to another room; the first room is tried at the pose by the graph, and with any heading."""
    corridor = outline((-9.0, -1.0), (9.0, -1.0), (9.0, 1.0), (-9.0, 1.0))
    graph = twice_in(L_ROOM, DRIFT, broken=True)
    graph.keys[3:] = twice_in(corridor, DRIFT, broken=True).keys[3:]
    finder = LoopFinder(graph, CondensedGraph(graph, 30.0), LeastSquaresConfig(), SurfelMapConfig())
    for submap in graph.submaps.values():
        finder.add(submap)
    assert finder.find(graph.submaps[1]) == 0
    assert finder.tried >= 2
    assert graph.loops == []
