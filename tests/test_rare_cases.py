"""Rare cases of compiled loops, on inputs so small that they are tested uncompiled too: see ``make coverage``."""

import numpy as np
import pytest

from slam.graph.constellation import CELLS, Constellation
from slam.graph.wall_landmarks import LINE_NX, LINE_NY, LINE_X, _drop_deviating
from slam.graph.wall_votes import REACH, SHIFTS, TURN_BINS, TURNS, TURNS_APART, places_voted_for, shift_votes
from slam.lines.beam_sums import chi_square, prefix_sums
from slam.lines.learnt_noise import ASSUMED, BANDS, MEMORY, SIZES, LearntNoise, _peak
from slam.lines.partition import Partition, merge_three
from slam.lines.prefix_sums import runs_and_lines
from slam.lines.wall_lines import wall_lines
from slam.mapping.free_beams import beam_towards, free_beams
from slam.mapping.predicted_view import EDGE_ON, compare_view
from slam.mapping.surfel_grid import Grid, empty_grid
from slam.mapping.surfel_updates import put
from slam.mapping.wall_corners import meet_at_corners
from slam.mapping.wall_doubles import without_doubles
from slam.matching.coarse_search import PLACE_X, PLACE_Y, SCORE, correlative_search
from slam.matching.wall_heading import MIN_LENGTH, _long_walls, turn_to_main
from slam.pose import FloatArray
from slam.scan import LaserScan

ORIGIN = np.zeros(3)
WALL = np.array([[0.0, 0.0, 1.0, 0.0, 1.0]])
"""One wall of a constellation: a metre along x about the origin."""


def facets_at(points: list[tuple[float, float]], normal: tuple[float, float]) -> FloatArray:
    """Facets (F, 7) at these points, which all face the same way."""
    return np.array([(x, y, *normal, 1e-4, 5.0, 0.0) for x, y in points])


def grid_of(facets: FloatArray) -> Grid:
    grid = empty_grid(0.2)
    put(grid, facets, ORIGIN, 0.1, 20.0, 0.0)
    return grid


def test_free_floor_ends_at_its_last_cell() -> None:
    """Only 16 m to each side are kept of a hall of 40 m; the row through its middle is completely free."""
    corners = 20.0 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    free = Constellation.of(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)).free
    assert free[CELLS].all()
    assert not Constellation.of(np.empty((0, 2, 2))).free.any()


def test_pieces_off_the_refitted_line_are_dropped() -> None:
    def piece(x: float, y: float) -> FloatArray:
        return 1e4 * np.array([1.0, x, y, x * x, x * y, y * y, 0.0, 1.0, 0.0, 0.0, 1.0])

    pieces = np.array([piece(0.0, 1.0), piece(0.3, 1.0), piece(0.6, 1.05)])
    wall_of, sums, line = np.zeros(3, np.int64), pieces.sum(axis=0), np.zeros(4)
    line[[LINE_NX, LINE_NY]], line[LINE_X:] = (0.0, 1.0), (0.15, 1.0)
    _drop_deviating(pieces, np.array([1, 2]), 0.01, wall_of, sums, line)
    assert wall_of.tolist() == [0, 0, -1]
    np.testing.assert_allclose(sums, pieces[:2].sum(axis=0))


def test_a_short_wall_has_few_places_along_itself() -> None:
    """The votes form a strip of seven cells, and two places must be more than two cells apart."""
    places = places_voted_for(WALL, WALL)
    assert 0 < len(places) < SHIFTS
    assert (places[:, SCORE] > 0.0).all()
    best = places[np.argmax(places[:, SCORE])]
    assert np.abs(best[[PLACE_X, PLACE_Y]]).max() <= 0.25


def test_few_distinct_turns_are_examined() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    walls = np.column_stack(
        [3.0 * np.sin(angles), -3.0 * np.cos(angles), np.cos(angles), np.sin(angles), 0 * angles + 1]
    )
    turns = np.unique(np.round(places_voted_for(walls, walls)[:, 3] * TURN_BINS / (2.0 * np.pi)))
    assert len(turns) == TURNS
    assert np.diff(turns).min() >= TURNS_APART


def test_walls_out_of_reach_have_no_vote() -> None:
    far = WALL + np.array([0.25 * (REACH + 8), 0.0, 0.0, 0.0, 0.0])
    assert not shift_votes(WALL, far).any()
    assert shift_votes(WALL, WALL).any()


def test_the_memory_of_a_range_is_limited() -> None:
    counts = np.ones((BANDS, SIZES))
    counts[3, :10] = MEMORY / 5.0
    learnt, before = LearntNoise(counts.copy()), counts[3] / counts[3].sum()
    learnt.observe(LaserScan(0.0, -1.0, 0.1, 0.05, 8.0, np.full(21, np.inf)))
    assert learnt.counts[3].sum() == pytest.approx(MEMORY)
    np.testing.assert_allclose(learnt.counts[3] / MEMORY, before)
    np.testing.assert_array_equal(np.delete(learnt.counts, 3, axis=0), 1.0)


@pytest.mark.parametrize("theta", [*np.arange(-3.0, 3.1, 0.75).tolist(), 0.0, 0.5 * np.pi])
@pytest.mark.parametrize("rho", [0.05, 0.3, 4.0])
def test_exact_points_lie_on_the_line_that_is_found(theta: float, rho: float) -> None:
    normal, along = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
    points = rho * normal + np.linspace(-1.0, 1.5, 20)[:, None] * along
    runs, lines = runs_and_lines(points, 0.02, 2, 5, np.inf)
    assert runs.tolist() == [[0, 19]]
    assert lines[0, 0] == pytest.approx(rho, abs=1e-7)
    assert np.cos(lines[0, 1] - theta) == pytest.approx(1.0, abs=1e-12)


def test_a_gap_splits_a_line_if_enabled() -> None:
    x = np.concatenate([np.linspace(0.0, 1.0, 10), np.linspace(3.0, 4.0, 10)])
    points = np.column_stack([x, np.ones(20)])
    assert runs_and_lines(points, 0.02, 2, 5, np.inf)[0].tolist() == [[0, 19]]
    assert runs_and_lines(points, 0.02, 2, 5, 1.0)[0].tolist() == [[0, 9], [10, 19]]


@pytest.mark.parametrize(("middle", "radius"), [((2.0, 1.0), 0.0), ((2.0, 1.0), 1e-3), ((0.0, 0.0), 0.5)])
def test_points_around_one_place_have_a_line_through_it(middle: tuple[float, float], radius: float) -> None:
    angles = 2.0 * np.pi * np.arange(12) / 12
    points = middle + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    _, ((rho, theta),) = runs_and_lines(points, 3.0, 2, 5, np.inf)
    assert np.array(middle) @ (np.cos(theta), np.sin(theta)) == pytest.approx(rho, abs=1e-5)


def test_beams_of_one_bearing_make_no_wall() -> None:
    """Points at one bearing do not determine a line."""
    ranges, q = np.array([2.0, 2.1, 2.2]), 1e4
    totals = q * np.array([[3.0, ranges.sum(), 0.0, ranges @ ranges, 0.0, 0.0]])
    fan = np.stack([np.zeros(3), np.ones(3), np.zeros(3)])
    kept = wall_lines(np.array([[0, 2, 0, 2, 0]]), totals, fan, 0.01, 0.0, np.inf)[0]
    assert len(kept) == 0
    assert chi_square(np.vstack([np.zeros(6), totals]), 0, 1) == np.inf


def beams_on_a_wall() -> tuple[FloatArray, FloatArray]:
    """The fan (3, 15) and the prefix sums (16, 6) of beams that end on a wall 2 m ahead, 1.2 m long."""
    bearings = np.linspace(-0.3, 0.3, 15)
    fan = np.stack([bearings, np.cos(bearings), np.sin(bearings)])
    sums, beams, gaps = np.empty((16, 6)), np.empty(15, np.int64), np.empty(16, np.bool_)
    assert prefix_sums(2.0 / np.cos(bearings), fan, (0.1, 8.0), ASSUMED, sums, beams, gaps) == 15
    return fan, sums


def test_three_runs_of_one_wall_are_made_one() -> None:
    """They stay apart if there is a gap between them."""
    for gap, expected in ((False, [0, 15]), (True, [0, 5, 10, 15])):
        partition = Partition(np.array([0, 5, 10, 15]), np.array([True, False, gap, True]), np.zeros(4))
        runs = merge_three(beams_on_a_wall()[1], 3, partition, 1.0)
        assert partition.start[: runs + 1].tolist() == expected


def test_a_wall_is_kept_only_if_long_enough() -> None:
    fan, sums = beams_on_a_wall()
    for least, kept in ((1.0, 1), (1.5, 0)):
        numbers, lines = wall_lines(np.array([[0, 14, 0, 14, 0]]), sums[-1:], fan, 0.04, least, 0.1)[:2]
        assert len(numbers) == kept
        np.testing.assert_allclose(lines, np.reshape([[2.0, 0.0]] * kept, (-1, 2)), atol=1e-9)


def test_an_interpolated_peak_stays_within_the_values() -> None:
    values = -((np.arange(6) - 2.3) ** 2)
    assert _peak(values, 2) == pytest.approx(0.3)
    assert _peak(values, 0) == _peak(values, 5) == _peak(np.ones(3), 1) == 0.0


@pytest.mark.parametrize(
    ("begin", "end", "beside", "left"),
    [
        (1.0, 2.0, 0.1, [(0.0, 1.0), (2.0, 3.0)]),
        (-1.0, 1.0, 0.1, [(1.0, 3.0)]),
        (2.0, 4.0, -0.1, [(0.0, 2.0)]),
        (-1.0, 4.0, 0.1, []),
        (-1.0, 4.0, 0.5, [(0.0, 3.0)]),
        (4.0, 5.0, 0.1, [(0.0, 3.0)]),
    ],
)
def test_a_better_wall_replaces_its_part_of_another(
    begin: float, end: float, beside: float, left: list[tuple[float, float]]
) -> None:
    walls = np.array([[[0.0, 0.0], [3.0, 0.0]], [[begin, beside], [end, beside]]])
    kept = without_doubles(walls, np.array([1.0, 9.0]), 0.2)
    assert kept[0].tolist() == walls[1].tolist()
    parts = sorted(kept[1:, :, 0].tolist())
    np.testing.assert_allclose(np.reshape(parts, (-1, 2)), np.reshape(left, (-1, 2)), atol=1e-12)


def test_a_corner_does_not_reverse_a_short_wall() -> None:
    """The corner is near its start, which moves to the corner; its end stays."""
    walls = np.array([[[0.04, -1.0], [0.04, 1.0]], [[0.0, 0.0], [0.22, 0.0]]])
    np.testing.assert_allclose(meet_at_corners(walls)[1], [[0.04, 0.0], [0.22, 0.0]], atol=1e-12)


def test_beams_without_a_reading_do_not_score_a_pose() -> None:
    bearings = np.linspace(-0.5, 0.5, 21)
    grid = grid_of(facets_at([(2.0, y) for y in np.arange(-1.3, 1.3, 0.2)], (1.0, 0.0)))
    ranges = 2.0 / np.cos(bearings)
    ranges[::2] = np.nan
    scan = LaserScan(0.0, -0.5, 0.05, 0.05, 8.0, ranges)
    view = compare_view(grid, free_beams(scan, 4.0), scan.echoes, ORIGIN, 8.0)
    assert view.agreeing > 0.4
    assert view.through == view.hidden == 0.0
    assert view.agreeing == pytest.approx(round(10 * view.agreeing) / 10)  # ten beams have a reading


def test_no_wall_is_predicted_for_a_beam_that_grazes_it() -> None:
    """A near surfel spans many beams. It is predicted only for those whose cosine of incidence is at least half of
    EDGE_ON."""
    x, y = 0.14, 0.04
    grid, bearings = grid_of(facets_at([(x, y)], (0.0, 1.0))), np.arange(-0.6, 1.0, 0.01)
    scan = LaserScan(0.0, -0.6, 0.01, 0.02, 8.0, np.full(len(bearings), 3.0))
    beams = free_beams(scan, 4.0)
    view = compare_view(grid, beams, scan.echoes, ORIGIN, 8.0)
    crossed = np.sin(bearings) >= 0.5 * EDGE_ON
    assert 0.0 < view.through <= crossed.mean()
    assert view.agreeing == view.hidden == 0.0


def test_facets_out_of_reach_change_no_place() -> None:
    wall = facets_at([(1.0, 0.2 * k) for k in range(-4, 5)], (1.0, 0.0))
    grid, far = grid_of(wall), facets_at([(3.0, 0.0)], (1.0, 0.0))
    near, both = (
        correlative_search(facets, ORIGIN, np.eye(3), 0.2, 0.02, 2.0, grid)
        for facets in (wall, np.concatenate([wall, far]))
    )
    np.testing.assert_array_equal(near, both)
    assert near[:, SCORE].max() > 5.0


def test_short_and_unsure_segments_give_no_heading() -> None:
    theta, start = np.zeros(3), np.zeros((3, 2))
    end = np.array([[0.0, MIN_LENGTH + 0.1], [0.0, MIN_LENGTH - 0.1], [0.0, 5.0]])
    covariance = np.tile(1e-6 * np.eye(2), (3, 1, 1))
    covariance[2, 1, 1] = 1.0
    assert len(_long_walls(theta, start, end, covariance)) == 1


@pytest.mark.parametrize(("walls", "turn"), [((2.0, 92.0, 182.0), -2.0), ((5.0,), None), ((40.0, 45.0), None)])
def test_walls_turn_the_scan_into_a_main_direction(walls: tuple[float, ...], turn: float | None) -> None:
    """The building has main directions at 0 and 10 degrees; walls midway between them, or far from both, do not
    count."""
    rows = np.array([(np.radians(wall), 1e-6, 3.0) for wall in walls])
    main = np.array([(0.0, 1e-6), (np.radians(10.0), 1e-6)])
    found, variance = turn_to_main(rows, main, 0.0, np.radians(7.0))
    assert np.isfinite(variance) == (turn is not None)
    assert np.degrees(found) == pytest.approx(turn or 0.0, abs=1e-6)


def test_a_beam_is_found_in_a_fan_that_was_deskewed() -> None:
    even = np.arange(-1.0, 1.0, 0.01)
    bearings = 1.05 * even  # the sensor turned while it scanned
    fan = np.ascontiguousarray(np.stack([bearings, np.cos(bearings), np.sin(bearings)]))
    beams = free_beams(LaserScan(0.0, -1.0, 0.01, 0.05, 8.0, np.full(len(even), 2.0), beam_fan=fan), 4.0)
    for j in (10, 60, 100, 190):
        assert beam_towards(beams, ORIGIN, np.cos(bearings[j]), np.sin(bearings[j])) == j
