"""The simulated lidar: true ranges and added errors."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.lidar import SimulatedLidar
from sim.lidar_noise import measure
from sim.rays import ScanMotion
from slam.lidars import LIDARS, TABLE1, URG04LX
from slam.pose import Pose2D
from slam.scenario.furniture import Table
from slam.scenario.lidar_config import LidarConfig
from slam.scenario.values import Place
from slam.scenario.wall import Wall
from slam.scenario.world_plan import World as Plan

ROOM = Plan(walls=(Wall(points=((-2.05, -2.05), (2.05, -2.05), (2.05, 2.05), (-2.05, 2.05)), closed=True),))
"""Four metres square inside."""
HERE = Place()
EXACT = LidarConfig(noise="none", rolling=False, mount=HERE)


def world_of(plan: Plan) -> Any:
    from sim.world import World  # late: PyBullet

    return World(plan.prisms(), 240)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def still(T_map_base: Pose2D) -> ScanMotion:
    """All beams from one place, with nobody around."""
    return ScanMotion(np.array([[T_map_base.x, T_map_base.y, T_map_base.theta]]), np.empty((1, 0, 2)), 0.1)


def room_ranges(T_map_laser: Pose2D, angles: np.ndarray) -> np.ndarray:
    """Closed form of the distances to the walls of ROOM."""
    c, s = np.cos(angles + T_map_laser.theta), np.sin(angles + T_map_laser.theta)
    with np.errstate(divide="ignore"):
        return np.minimum((2.0 - np.sign(c) * T_map_laser.x) / abs(c), (2.0 - np.sign(s) * T_map_laser.y) / abs(s))


@pytest.mark.parametrize("caster", ["bullet", "exact"])
@pytest.mark.parametrize("model", LIDARS)
@pytest.mark.parametrize("pose", [Pose2D(0.0, 0.0, 0.001), Pose2D(0.7, -1.1, 2.3), Pose2D(-1.0, 0.4, -0.8)])
def test_ranges_in_a_square_room_have_the_closed_form(model: Any, caster: str, pose: Any) -> None:
    config = LidarConfig(model=model, noise="none", caster=caster, mount=HERE)
    with world_of(ROOM) as world:
        ranges = SimulatedLidar(world, config).true_ranges(still(pose))
    assert ranges == pytest.approx(room_ranges(pose, config.description.lidar.angles), abs=1e-4)


def test_the_scan_carries_its_fan_its_stamp_and_its_sensor() -> None:
    with world_of(ROOM) as world:
        scan = SimulatedLidar(world, EXACT).scan(still(Pose2D()), 12.5, rng())
    assert scan.lidar == URG04LX.lidar
    assert scan.stamp == 12.5
    assert scan.time_increment == 0.0
    assert scan.ranges == pytest.approx(room_ranges(Pose2D(), scan.lidar.angles), abs=0.5001e-3)
    assert np.abs(scan.points()).max() == pytest.approx(2.0, abs=1e-3)


def test_a_low_lidar_sees_table_legs_and_a_high_one_the_top() -> None:
    plan = Plan(tables=(Table(center=(2.0, 0.0), size=(1.0, 1.0, 0.7)),))
    with world_of(plan) as world:
        low = SimulatedLidar(world, LidarConfig(height=0.3, mount=HERE)).true_ranges(still(Pose2D()))
        high = SimulatedLidar(world, LidarConfig(height=0.69, mount=HERE)).true_ranges(still(Pose2D()))
    ahead = 384 - 44
    assert low[ahead] == np.inf
    assert high[ahead] == pytest.approx(1.5, abs=1e-4)
    assert 0 < np.isfinite(low).sum() < np.isfinite(high).sum()


def test_no_echo_is_inf_and_too_close_is_minus_inf() -> None:
    ranges = measure(np.array([0.03, 0.0602, 4.0949, 4.11, np.inf]), 0.0, EXACT, rng())
    assert ranges.tolist() == pytest.approx([-np.inf, 0.06, 4.095, np.inf, np.inf])


@given(st.sampled_from(sorted(LIDARS)), st.floats(0.0, 1.0))
def test_ranges_in_reach_become_the_nearest_step(name: Any, share: float) -> None:
    model = LIDARS[name]
    lidar = model.lidar
    true = lidar.range_min + share * (lidar.range_max - lidar.range_min)
    (reported,) = measure(np.array([true]), 0.0, LidarConfig(model=name, noise="none"), rng())
    steps = (reported - lidar.range_min) / model.resolution
    assert lidar.range_min <= reported <= lidar.range_max
    assert abs(reported - true) <= model.resolution / 2 + 0.51e-6
    assert abs(steps - round(steps)) * model.resolution <= 0.51e-6  # whole micrometres


def test_table_1_has_1024_steps() -> None:
    lidar = TABLE1.lidar
    true = np.linspace(lidar.range_min, lidar.range_max, 100_000)
    reported = measure(true, 0.0, LidarConfig(model="table1", noise="none"), rng())
    assert len(np.unique(reported.round(9))) == 1025


@pytest.mark.parametrize(("true", "bound"), [(0.5, 0.025), (1.0, 0.025), (2.0, 0.05), (3.5, 0.0875)])
@pytest.mark.parametrize("bound_sigmas", [2.0, 3.0])
def test_the_noise_is_gaussian_within_the_data_sheet(true: float, bound: float, bound_sigmas: float) -> None:
    config = LidarConfig(bound_sigmas=bound_sigmas)
    errors = measure(np.full(40_000, true), 0.0, config, rng()) - true
    sigma = bound / bound_sigmas
    assert np.std(errors) == pytest.approx(sigma, rel=0.02)
    assert abs(np.mean(errors)) < 4 * sigma / 200
    assert np.mean(abs(errors) < sigma) == pytest.approx(0.6827, abs=0.06)  # the steps of 1 mm change it
    assert np.mean(abs(errors) > 2.5 * sigma) == pytest.approx(0.0124, abs=0.004)


def test_noise_at_the_reach_does_not_bias_the_echo_count() -> None:
    wall = Plan(walls=(Wall(points=((4.145, -9.0), (4.145, 9.0))),))  # its face stands at the reach of 4.095 m
    with world_of(wall) as world:
        lidar = SimulatedLidar(world, LidarConfig(mount=HERE))
        ahead = [np.isfinite(lidar.scan(still(Pose2D()), 0.0, rng(seed)).ranges[340]) for seed in range(300)]
    assert 0.35 < np.mean(ahead) < 0.65


def test_dropout_loses_its_share_of_the_echoes() -> None:
    ranges = measure(np.full(20_000, 2.0), 0.0, LidarConfig(dropout=0.1), rng())
    assert np.mean(np.isinf(ranges)) == pytest.approx(0.1, abs=0.01)
    assert np.isinf(measure(np.full(10, 2.0), 0.0, LidarConfig(dropout=1.0), rng())).all()


def test_the_seed_alone_decides_the_noise() -> None:
    true = np.linspace(0.1, 4.0, 682)
    first, again, other = (measure(true, 0.0, LidarConfig(), rng(seed)) for seed in (7, 7, 8))
    assert (first == again).all()
    assert (first != other).mean() > 0.8


def test_every_scan_draws_as_many_random_numbers() -> None:
    near, far, none = rng(3), rng(3), rng(3)
    measure(np.full(682, 1.0), 0.0, LidarConfig(), near)
    measure(np.full(682, np.inf), 0.0, LidarConfig(), far)
    measure(np.full(682, 1.0), 0.0, EXACT, none)
    assert near.random() == far.random() == none.random()
