"""The noise of the simulated lidar, most of all the parts of the realistic one."""

from typing import get_args

import numpy as np
import pytest

from sim.lidar_noise import NOISES, measure
from sim.realistic_noise import BEAM_HALF_WIDTH, WARM_UP, WARM_UP_TIME, incidence, mixed_pixels
from slam.lidars import URG04LX
from slam.scenario.lidar_config import LidarConfig, NoiseName

ANGLES = URG04LX.lidar.angles
STEP = URG04LX.lidar.angle_increment
REALISTIC = LidarConfig(noise="realistic")
WARM = 100.0 * WARM_UP_TIME


def wall(distance: float) -> np.ndarray:
    """Ranges to an endless wall straight ahead."""
    with np.errstate(divide="ignore"):
        return np.where(abs(ANGLES) < 1.5, distance / np.cos(ANGLES), np.inf)


def many(ranges: np.ndarray, config: LidarConfig = REALISTIC, time: float = WARM) -> np.ndarray:
    rng = np.random.default_rng(0)
    return np.array([measure(ranges, time, config, rng) for _ in range(400)])


def test_every_noise_of_a_scenario_has_a_function() -> None:
    assert set(NOISES) == set(get_args(NoiseName))


def test_the_incidence_on_a_wall_is_the_bearing() -> None:
    seen = abs(ANGLES) < 1.4
    assert incidence(wall(1.0), STEP)[seen] == pytest.approx(np.cos(ANGLES[seen]), abs=6e-3)


def test_errors_grow_with_range_and_incidence() -> None:
    ahead, aslant = 340, 340 + 170  # 0 and 60 degrees
    near, far = many(wall(0.5)), many(wall(1.9))
    assert np.std(near[:, ahead]) == pytest.approx(np.hypot(0.003, 0.0033 * 0.5), rel=0.15)
    assert np.nanstd(far[:, ahead]) == pytest.approx(np.hypot(0.003, 0.0033 * 1.9), rel=0.15)
    assert np.nanstd(far[:, aslant]) > 1.5 * np.nanstd(far[:, ahead])


def test_echoes_are_lost_with_range_incidence_and_dark_surfaces() -> None:
    lost = np.isnan(many(wall(1.9)))
    dark = np.isnan(many(wall(1.9), LidarConfig(noise="realistic", reflectivity=0.1)))
    assert lost[:, 340].mean() < 0.01
    assert lost[:, 340 + 165].mean() > 0.01
    assert dark[:, 340].mean() == pytest.approx(np.exp(-0.1 / 1.9**2 / 0.01), abs=0.06)


def test_a_missing_echo_stays_missing() -> None:
    assert np.isposinf(many(np.full(682, np.inf))).all()


def edge_at(beam: int, near: float, far: float) -> np.ndarray:
    return np.where(np.arange(682) < beam, near, far)


def test_beams_beside_an_edge_give_ranges_in_between() -> None:
    ranges = edge_at(300, 1.0, 3.0)
    readings = many(ranges)
    between = (readings > 1.1) & (readings < 2.8)
    assert between[:, 299:301].any(axis=1).mean() > 0.3
    assert between[:, :298].sum() == between[:, 303:].sum() == 0


def test_mixed_ranges_are_weighted_by_the_light() -> None:
    share = 0.3
    mixed = mixed_pixels(edge_at(300, 1.0, 3.0), STEP, np.full(682, share))
    over = (BEAM_HALF_WIDTH - share * STEP) / (2.0 * BEAM_HALF_WIDTH)
    light = np.array([1.0 - over, over / 9.0])
    assert mixed[299] == pytest.approx(light @ [1.0, 3.0] / light.sum())
    assert (mixed[:299] == 1.0).all()


def test_slanting_walls_and_corners_have_no_edge() -> None:
    corner = np.minimum(wall(1.5), np.where(ANGLES > 0.01, 1.0 / np.sin(np.maximum(ANGLES, 0.01)), np.inf))
    assert abs(np.diff(wall(0.5)[np.isfinite(wall(0.5))])).max() > 0.2
    for ranges in (wall(0.5), corner):
        assert (mixed_pixels(ranges, STEP, np.full(682, 0.5)) == ranges).all()


def test_ranges_are_too_long_until_the_sensor_is_warm() -> None:
    bias = [np.nanmean(many(wall(1.0), time=time)[:, 340]) - 1.0 for time in (0.0, WARM_UP_TIME, WARM)]
    assert bias == pytest.approx([WARM_UP, WARM_UP / np.e, 0.0], abs=1e-3)


def test_bounds_of_the_data_sheet_are_three_sigmas() -> None:
    sheet = many(wall(2.0), LidarConfig(noise="datasheet"))[:, 340] - 2.0
    close = many(wall(0.5), LidarConfig(noise="datasheet"))[:, 340] - 0.5
    assert np.std(sheet) == pytest.approx(0.02 / 3.0, rel=0.15)
    assert np.std(close) == pytest.approx(0.01 / 3.0, rel=0.15)


def test_every_scan_draws_as_many_random_numbers() -> None:
    rngs = [np.random.default_rng(3) for _ in range(3)]
    for rng, ranges in zip(rngs, (wall(1.0), np.full(682, np.inf), edge_at(300, 0.01, 2.0)), strict=True):
        measure(ranges, 0.0, REALISTIC, rng)
    assert len({rng.random() for rng in rngs}) == 1
