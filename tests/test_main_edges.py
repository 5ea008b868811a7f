"""Main directions of a building, and the alignment of its walls with them."""

import numpy as np
import pytest

from slam.graph.main_edges import PART, find_main_edges, variance_components
from slam.pose import FloatArray


def walls_of_parts(askew: float, apart: float, each: int = 20, parts: int = 12) -> tuple[FloatArray, FloatArray]:
    """Directions (M,) and places (M, 2) of walls, radians and metres, in parts of a building that stand in a row.

    Each part is off by ``askew`` degrees, and each of its walls by ``apart``, one standard deviation.
    """
    random = np.random.default_rng(3)
    part = np.repeat(np.arange(parts), each)
    off: FloatArray = askew * random.standard_normal(parts)[part] + apart * random.standard_normal(len(part))
    quarters = 0.5 * np.pi * random.integers(0, 4, len(part))
    places = np.asarray(PART * (np.column_stack([part, np.zeros(len(part))]) + random.random((len(part), 2))), float)
    return np.radians(20.0 + off) + quarters, places


def test_walls_of_random_directions_have_no_main_direction() -> None:
    found = find_main_edges(np.linspace(0.0, 6.0, 40), np.full(40, 5.0), np.zeros((40, 2)))
    assert (found.direction == -1).all()
    assert not found.information.any()


def test_walls_of_a_straight_building_are_aligned() -> None:
    theta, places = walls_of_parts(askew=0.0, apart=0.4)
    found = find_main_edges(theta, np.full(len(theta), 3.0), places)
    assert (found.direction == 0).mean() > 0.95
    assert found.information.sum() > 0.5 * len(theta) / np.radians(0.4) ** 2


def test_parts_with_their_own_directions_are_not_aligned() -> None:
    theta, places = walls_of_parts(askew=0.8, apart=0.2)
    found = find_main_edges(theta, np.full(len(theta), 3.0), places)
    assert (found.direction == -1).all()


def test_walls_of_one_part_are_one_observation() -> None:
    """The parts of the building are a little askew; the number of walls of each changes nothing."""
    information = []
    for each in (20, 200):
        theta, places = walls_of_parts(askew=0.3, apart=0.5, each=each, parts=30)
        information.append(find_main_edges(theta, np.full(len(theta), 3.0), places).information.sum())
    assert 0.0 < information[1] < 2.0 * information[0]


def test_a_single_part_counts_as_one_wall() -> None:
    theta, places = walls_of_parts(askew=0.0, apart=0.4, parts=1, each=40)
    found = find_main_edges(theta, np.full(len(theta), 3.0), places)
    assert 0.0 < found.information.sum() < 1.0 / np.radians(0.3) ** 2


def test_variances_within_and_between_parts_are_separated() -> None:
    random = np.random.default_rng(0)
    counts = random.integers(2, 60, 400)
    part = np.repeat(np.arange(len(counts)), counts)
    values = 3.0 * random.standard_normal(len(counts))[part] + 2.0 * random.standard_normal(len(part))
    assert variance_components(values, part, counts) == pytest.approx((4.0, 9.0), rel=0.15)
