"""The main directions of a building, and the heading found from them."""

from collections.abc import Callable
from itertools import pairwise
from math import cos, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.config import SlamConfig
from slam.line_slam import LineSlam
from slam.mapping.directions import MAX_CLUSTERS, Directions
from slam.matching.wall_heading import WallHeading, turn_to_main
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

Scanner = Callable[[FloatArray, Pose2D, int], LaserScan]
QUARTER = pi / 2
ANGLES = st.floats(-10.0, 10.0)
EXACT = radians(0.3) ** 2  # the least variance of a direction


def learnt(theta: FloatArray, length: float = 5.0, variance: float = 0.0) -> Directions:
    directions = Directions()
    for one in theta:
        directions.add(np.array([[one, variance, length]]))
    return directions


def apart(a: float, b: float) -> float:
    """Size of the difference of two angles, modulo a quarter turn."""
    return abs((a - b + QUARTER / 2) % QUARTER - QUARTER / 2)


def walls_at(*degrees: float, length: float = 5.0) -> FloatArray:
    return np.array([(radians(one), 1e-6, length) for one in degrees])


def main_at(*degrees: float) -> FloatArray:
    return np.array([(radians(one), EXACT) for one in degrees])


@given(turn=ANGLES, seed=st.integers(0, 20))
def test_the_directions_turn_with_the_world(turn: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    walls = random.integers(0, 4, 60) * QUARTER + random.normal(0.0, 0.004, 60)
    (one,), (other,) = learnt(walls).main, learnt(walls + turn).main
    assert apart(other[0], one[0] + turn) < 1e-9
    assert other[1] == pytest.approx(one[1], abs=1e-12)


@given(turn=ANGLES)
def test_the_heading_turns_with_the_scan(turn: float) -> None:
    walls = walls_at(1.0, 91.2, 180.8)
    asked, variance = turn_to_main(walls, main_at(0.0), 0.0, radians(8.0))
    turned = walls + np.array([turn, 0.0, 0.0])
    again, same = turn_to_main(turned, main_at(0.0), -turn, radians(8.0))
    assert again == pytest.approx(asked, abs=1e-9)
    assert same == pytest.approx(variance)


def test_a_right_angled_building_has_one_direction() -> None:
    random = np.random.default_rng(1)
    walls = random.integers(0, 4, 400) * QUARTER + 0.3 + random.normal(0.0, radians(0.6), 400)
    ((direction, variance),) = learnt(walls).main
    assert direction == pytest.approx(0.3, abs=radians(0.1))
    assert np.sqrt(variance) == pytest.approx(radians(0.6), rel=0.15)


def test_measurement_noise_is_no_spread_of_the_building() -> None:
    walls = np.random.default_rng(2).normal(0.0, radians(0.5), 400)
    ((_, variance),) = learnt(walls, variance=radians(0.5) ** 2).main
    assert variance == pytest.approx(EXACT)


def test_two_wings_have_two_directions() -> None:
    wings = learnt(np.tile([0.0, radians(30.0)], 40)).main
    assert sorted(np.degrees(wings[:, 0])) == pytest.approx([0.0, 30.0])


def test_walls_two_degrees_apart_make_an_unsure_direction() -> None:
    random = np.random.default_rng(3)
    walls = random.choice([0.0, radians(1.9)], 200)
    ((direction, variance),) = learnt(walls).main
    assert direction == pytest.approx(radians(0.95), abs=radians(0.2))
    assert np.sqrt(variance) > radians(0.8)


@given(seed=st.integers(0, 20))
def test_a_round_room_has_no_direction(seed: int) -> None:
    assert len(learnt(np.random.default_rng(seed).uniform(0.0, 2 * pi, 300)).main) == 0


def test_a_few_walls_are_no_evidence() -> None:
    assert len(learnt(np.zeros(5)).main) == 0


def test_a_well_known_mean_ignores_a_drifting_heading() -> None:
    directions = learnt(np.zeros(250))
    drifting = np.linspace(0.0, radians(1.5), 2000)
    for one in drifting:
        directions.add(np.array([[one, 0.0, 5.0]]))
    assert apart(directions.main[0, 0], 0.0) < 1e-12
    assert directions.clusters.shape == (MAX_CLUSTERS, 3)


def test_the_heading_is_found_from_three_walls() -> None:
    turn, variance = turn_to_main(walls_at(2.0, 92.0, 182.0), main_at(0.0), 0.0, radians(8.0))
    assert np.degrees(turn) == pytest.approx(-2.0, abs=1e-6)
    assert variance == pytest.approx(EXACT + 1e-6)


@pytest.mark.parametrize(
    ("walls", "main"),
    [
        (walls_at(20.0, 25.0), main_at(0.0)),  # too far
        (walls_at(1.0, 20.0, 33.0), main_at(0.0)),  # a minority
        (walls_at(5.0), main_at(0.0, 10.0)),  # either way
    ],
)
def test_ambiguous_walls_give_no_heading(walls: FloatArray, main: FloatArray) -> None:
    assert turn_to_main(walls, main, 0.0, radians(8.0)) == (0.0, np.inf)


def test_without_directions_the_prior_keeps_every_bit() -> None:
    prior, information = np.array([1.0, 2.0, 0.3]), np.diag([1e4, 1e4, 1e3])
    better, surer = WallHeading(Directions()).refine_prior(prior, information, 0.3, 0.1)
    assert better is prior
    assert surer is information


def hall(tilt: float) -> FloatArray:
    """Corners of a hall 24 m long, its end walls off the right angle by ``tilt`` radians."""
    lean = 1.5 * np.tan(tilt)
    return np.array([[-4 - lean, -1.5], [20 - lean, -1.5], [20 + lean, 1.5], [-4 + lean, 1.5], [-4 - lean, -1.5]])


NONAGON = 3.0 * np.array([(cos(0.3 + 2 * pi * k / 9), sin(0.3 + 2 * pi * k / 9)) for k in range(10)])


def headings(scan_of: Scanner, corners: FloatArray, directions: str, path: list[Pose2D], seed: int) -> FloatArray:
    """Estimates along the path with wheels whose heading is off by 1.7 degrees a step, (N,)."""
    random, wheels = np.random.default_rng(seed), [Pose2D()]
    for a, b in pairwise(path):
        step = a.between(b)
        wheels.append(wheels[-1] @ Pose2D(step.x, step.y, step.theta + 0.03 * random.normal()))
    slam = LineSlam(SlamConfig.model_validate({"matching": {"directions": directions}}), Pose2D(), path[0])
    scans = [scan_of(corners, pose, 100 * seed + k) for k, pose in enumerate(path)]
    updates = [slam.update(scan, Odometry(scan.stamp, T)) for scan, T in zip(scans, wheels, strict=True)]
    return np.array([estimate.T_map_base.theta for estimate in updates])


@pytest.mark.parametrize("tilt", [0.0, 2.0])
def test_directions_reduce_the_drift_in_a_hall(scan_of: Scanner, tilt: float) -> None:
    path = [Pose2D(0.4 * k, 0.3 * sin(0.2 * k), 0.1 * cos(0.2 * k)) for k in range(40)]
    truth, corners = np.array([pose.theta for pose in path]), hall(radians(tilt))
    error = {
        directions: np.mean([np.abs(headings(scan_of, corners, directions, path, s) - truth).mean() for s in range(3)])
        for directions in ("auto", "never")
    }
    assert error["auto"] <= error["never"] + radians(0.05)


def test_without_directions_the_run_is_bit_for_bit_the_same(scan_of: Scanner) -> None:
    path = [Pose2D(0.02 * k, 0.0, 0.05 * k) for k in range(30)]
    auto, never = (headings(scan_of, NONAGON, directions, path, 1) for directions in ("auto", "never"))
    assert np.array_equal(auto, never)
