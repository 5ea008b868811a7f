"""The cells that a scan marks, against geometry that checks every cell and every pair of beams."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.env.occupancy_grid import Extent, OccupancyGrid, seen_ranges
from slam.env.scan_fill import FREE, UNKNOWN, WALL, mark_scan
from slam.pose import Pose2D, unit_vectors
from slam.scan import LaserScan

SIZE = 12
place = st.floats(-4.0, SIZE + 4.0)
lengths = st.lists(st.sampled_from([0.0, 1.0, 20.0]) | st.floats(0.01, 20.0), min_size=2, max_size=30)


def depth_in(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance of points (N, 2) from the nearest side of a counter-clockwise triangle (3, 2); negative outside."""
    along = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([-along[:, 1], along[:, 0]], axis=-1) / np.linalg.norm(along, axis=1)[:, None]
    return ((points[:, None] - corners) * normals).sum(axis=-1).min(axis=-1)


@given(place, place, st.floats(-np.pi, np.pi), lengths, st.booleans(), st.booleans())
def test_a_scan_frees_the_cells_between_neighbouring_beams(
    x: float, y: float, first: float, lengths: list[float], whole_turn: bool, echo: bool
) -> None:
    """Two neighbouring beams span a triangle, and free the cells whose middle lies in it.

    A middle within 1e-9 of a side may be free or not.
    """
    cells, beams = np.zeros((SIZE, SIZE), np.uint8), len(lengths)
    whole_turn &= beams > 2
    bearings = first + np.arange(beams) * (2.0 * np.pi / beams if whole_turn else 3.0 / beams)
    ends = np.array([x, y]) + np.array(lengths)[:, None] * unit_vectors(bearings)
    echoes = np.array(lengths) > 0.0 if echo else np.zeros(beams, np.bool_)
    found = mark_scan(cells, x, y, ends.T.copy(), echoes, whole_turn)
    assert found == np.count_nonzero(cells)
    rows, columns = np.mgrid[:SIZE, :SIZE]
    middles = np.column_stack([columns.ravel(), rows.ravel()]) + 0.5
    depth = np.full(SIZE * SIZE, -np.inf)
    for k in range(beams if whole_turn else beams - 1):
        if lengths[k] and lengths[(k + 1) % beams]:
            triangle = np.array([[x, y], ends[k], ends[(k + 1) % beams]])
            depth = np.maximum(depth, depth_in(triangle, middles))
    depths = depth.reshape(SIZE, SIZE)
    walls = np.zeros((SIZE, SIZE), np.bool_)
    at = np.floor(ends[echoes]).astype(int)
    at = at[((at >= 0) & (at < SIZE)).all(axis=1)]
    walls[at[:, 1], at[:, 0]] = True
    np.testing.assert_array_equal(cells == WALL, walls)
    assert (cells[(depths > 1e-9) & ~walls] == FREE).all()
    assert (cells[(depths < -1e-9) & ~walls] == UNKNOWN).all()


@given(st.floats(-np.pi, np.pi), st.lists(st.floats(0.0, 6.0), min_size=2, max_size=9))
def test_newly_seen_area_is_that_of_the_marked_cells(theta: float, ranges: list[float]) -> None:
    grid = OccupancyGrid(Extent((-4.0, -4.0), (8.0, 8.0)), 0.25)
    scan = LaserScan(0.0, -1.0, 2.0 / len(ranges), 0.1, 5.0, np.array(ranges))
    first = grid.add_scan(scan, Pose2D(0.1, 0.2, theta))
    assert first == pytest.approx(np.count_nonzero(grid.cells) * 0.25**2)
    assert grid.add_scan(scan, Pose2D(0.1, 0.2, theta)) == 0.0


def test_only_runs_of_missing_echoes_are_open_space() -> None:
    ranges = np.array([2.0, np.inf, 2.0, np.nan, -np.inf, 2.0, np.inf, np.inf, np.inf])
    scan = LaserScan(0.0, 0.0, 0.1, 0.1, 3.0, ranges)
    assert seen_ranges(scan).tolist() == [2.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 3.0, 3.0]


def test_beams_free_cells_only_up_to_their_echo() -> None:
    grid = OccupancyGrid(Extent((-5.0, -5.0), (10.0, 10.0)), 1.0)
    grid.add_scan(LaserScan(0.0, -0.2, 0.2, 0.1, 3.0, np.full(3, 2.0)), Pose2D(0.4, 0.5))
    ahead = np.array([[1.5, 0.5], [2.5, 0.5], [3.5, 0.5]])
    np.testing.assert_array_equal(grid.at(ahead), [FREE, WALL, UNKNOWN])


def test_a_whole_turn_leaves_no_gap_at_its_seam() -> None:
    grid = OccupancyGrid(Extent((-5.0, -5.0), (10.0, 10.0)), 0.1)
    step = 2.0 * np.pi / 12
    scan = LaserScan(0.0, -np.pi + 0.1, step, 0.1, 5.0, np.full(12, 4.0))
    grid.add_scan(scan, Pose2D(0.0, 0.0, 0.3))
    around = 3.0 * unit_vectors(np.linspace(0.0, 2.0 * np.pi, 100))
    assert (grid.at(around) == FREE).all()


def test_outside_the_grid_everything_is_unknown() -> None:
    grid = OccupancyGrid(Extent((0.0, 0.0), (2.0, 1.0)), 0.5)
    scan = LaserScan(0.0, 0.0, 0.1, 0.1, 9.0, np.full(3, 8.0))
    assert grid.cells.shape == (2, 4)
    assert grid.add_scan(scan, Pose2D(-20.0, 0.5)) == 0.0
    assert grid.add_scan(scan, Pose2D(-5.0, 0.25)) > 0.0  # from outside to inside
    assert (grid.at(np.array([[-0.1, 0.1], [0.1, -0.1], [2.1, 0.1], [0.1, 1.1]])) == UNKNOWN).all()


def test_a_wall_stays_occupied() -> None:
    cells = np.zeros((3, 9), np.uint8)
    for length, echo in ((4.0, True), (8.4, False)):
        ends = np.array([[0.5 + length] * 2, [1.4, 1.6]])
        mark_scan(cells, 0.4, 1.5, ends, np.full(2, echo), False)
    assert cells[1].tolist() == [FREE, FREE, FREE, FREE, WALL, FREE, FREE, FREE, FREE]
