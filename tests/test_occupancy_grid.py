"""The cells that beams run through: against geometry that looks at every cell."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.env.occupancy_grid import FREE, UNKNOWN, WALL, Extent, OccupancyGrid, mark_rays, seen_ranges
from slam.pose import Pose2D
from slam.scan import LaserScan

SIZE = 12
inside = st.floats(0.01, SIZE - 0.01)


def chords(x: float, y: float, heading: float, length: float, inset: float) -> np.ndarray:
    """Length of the ray within each cell, smaller by ``inset`` on all sides, clipped to all of them at once (slabs)."""
    direction = np.array([np.cos(heading), np.sin(heading)])
    direction[np.abs(direction) < 1e-12] = 1e-12
    rows, columns = np.mgrid[:SIZE, :SIZE]
    low = np.stack([columns, rows], axis=-1) - np.array([x, y])
    borders = np.sort(np.stack([low + inset, low + 1.0 - inset]) / direction, axis=0)
    return np.minimum(borders[1].min(axis=-1), length) - np.maximum(borders[0].max(axis=-1), 0.0)


@given(inside, inside, st.floats(-np.pi, np.pi), st.floats(0.01, 20.0), st.booleans())
def test_a_ray_marks_the_cells_that_it_crosses_and_no_others(
    x: float, y: float, heading: float, length: float, echo: bool
) -> None:
    cells = np.zeros((SIZE, SIZE), np.uint8)
    found = mark_rays(cells, x, y, np.array([heading]), np.array([length]), np.array([echo]))
    assert (cells[chords(x, y, heading, length, inset=1e-9) > 0.0] != UNKNOWN).all()
    assert (cells[chords(x, y, heading, length, inset=-1e-9) < 0.0] == UNKNOWN).all()
    assert found == np.count_nonzero(cells)
    column, row = int(np.floor(x + length * np.cos(heading))), int(np.floor(y + length * np.sin(heading)))
    walls = np.argwhere(cells == WALL).tolist()
    assert walls == [] if not echo else all(abs(r - row) + abs(c - column) <= 1 for r, c in walls)


@given(st.floats(-np.pi, np.pi), st.lists(st.floats(0.0, 6.0), min_size=2, max_size=9))
def test_newly_seen_area_is_that_of_the_marked_cells_and_none_at_a_second_look(
    theta: float, ranges: list[float]
) -> None:
    grid = OccupancyGrid(Extent((-4.0, -4.0), (8.0, 8.0)), 0.25)
    scan = LaserScan(0.0, -1.0, 2.0 / len(ranges), 0.1, 5.0, np.array(ranges))
    first = grid.add_scan(scan, Pose2D(0.1, 0.2, theta))
    assert first == pytest.approx(np.count_nonzero(grid.cells) * 0.25**2)
    assert grid.add_scan(scan, Pose2D(0.1, 0.2, theta)) == 0.0


def test_a_beam_sees_up_to_its_echo_and_silence_is_open_space_only_among_silence() -> None:
    ranges = np.array([2.0, np.inf, 2.0, np.nan, -np.inf, 2.0, np.inf, np.inf, np.inf])
    scan = LaserScan(0.0, 0.0, 0.1, 0.1, 3.0, ranges)
    assert seen_ranges(scan).tolist() == [2.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 3.0, 3.0]


def test_a_beam_marks_what_lies_before_its_echo_and_no_more() -> None:
    grid = OccupancyGrid(Extent((-5.0, -5.0), (10.0, 10.0)), 1.0)
    grid.add_scan(LaserScan(0.0, 0.0, 0.1, 0.1, 3.0, np.array([2.0])), Pose2D(0.5, 0.5))
    ahead = np.array([[1.5, 0.5], [2.5, 0.5], [3.5, 0.5]])
    np.testing.assert_array_equal(grid.at(ahead), [FREE, WALL, UNKNOWN])


def test_outside_of_the_grid_nothing_is_seen_and_nothing_is_known() -> None:
    grid = OccupancyGrid(Extent((0.0, 0.0), (2.0, 1.0)), 0.5)
    scan = LaserScan(0.0, 0.0, 0.1, 0.1, 9.0, np.full(3, 8.0))
    assert grid.cells.shape == (2, 4)
    assert grid.add_scan(scan, Pose2D(-20.0, 0.5)) == 0.0
    assert grid.add_scan(scan, Pose2D(-5.0, 0.25)) > 0.0  # from outside to inside
    assert (grid.at(np.array([[-0.1, 0.1], [0.1, -0.1], [2.1, 0.1], [0.1, 1.1]])) == UNKNOWN).all()


def test_a_wall_stays_a_wall() -> None:
    cells = np.zeros((3, 9), np.uint8)
    for length, echo in ((4.0, True), (8.0, False)):
        mark_rays(cells, 0.5, 1.5, np.zeros(1), np.array([length]), np.array([echo]))
    assert cells[1].tolist() == [FREE] * 4 + [WALL] + [FREE] * 4
