"""The range noise learned over scans: laws, known answers, and the effect of clutter."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.bench.floor_plans import FAMILIES
from slam.bench.scenes import make_scene
from slam.config import ChiSquareConfig
from slam.lidars import URG04LX
from slam.lines.learnt_noise import NEAREST, OCTAVE, SIZES, SMALLEST, LearntNoise
from slam.lines.range_noise import RangeNoise
from slam.pose import FloatArray
from slam.scan import LaserScan

LIDAR = URG04LX.lidar
RATIOS = np.array([0.3, 0.7, 1.5, 3.0, 6.0])  # ranges at which noise is compared, metres


def scan_of(ranges: FloatArray, angle_min: float = LIDAR.angle_min, step: float = LIDAR.angle_increment) -> LaserScan:
    return LaserScan(0.0, angle_min, step, 0.02, 100.0, ranges)


def room(beams: int, random: np.random.Generator) -> FloatArray:
    """Ranges all around from a random place in a room of 6 m by 4 m with a pillar."""
    x, y = random.uniform(1.0, 5.0), random.uniform(0.5, 3.0)
    t = random.uniform(0.0, 1.0) + 2.0 * np.pi / beams * np.arange(beams)
    c, s = np.cos(t), np.sin(t)
    walls = np.minimum(np.where(c > 0, 6.0 - x, -x) / c, np.where(s > 0, 4.0 - y, -y) / s)
    return np.where(np.abs(t - 3.0) < 0.1, np.minimum(walls, 0.6), walls)


def white(noise: RangeNoise) -> RangeNoise:
    """The noise without its floor."""
    return noise._replace(floor=0.0)


def learnt(
    noise: RangeNoise, beams: int, scans: int, change: Callable[[FloatArray], FloatArray] = lambda r: r
) -> RangeNoise:
    """Return the noise that is learnt from ``scans`` scans of rooms."""
    random, learner = np.random.default_rng(beams), LearntNoise.start()
    for _ in range(scans):
        ranges = room(beams, random)
        ranges = ranges + noise.sigma(ranges) * random.standard_normal(beams)
        found = learner.observe(scan_of(change(ranges), 0.0, 2.0 * np.pi / beams))
    return found


@pytest.mark.parametrize("beams", [90, 360, 2728])
@pytest.mark.parametrize(("near", "far"), [(0.001, 0.0005), (0.008, 0.008), (0.03, 0.0), (0.02, 0.02)])
def test_the_learned_noise_is_the_true_noise(beams: int, near: float, far: float) -> None:
    """They agree within 10 % at the ranges that occur in the rooms."""
    noise = RangeNoise(near, near / far if far else np.inf, far, 0.0)
    r = np.array([0.6, 1.5, 3.0])
    np.testing.assert_allclose(white(learnt(noise, beams, 60)).sigma(r), noise.sigma(r), rtol=0.1)


@pytest.mark.parametrize("step", [0.01, 0.05])
def test_steps_of_the_range_count_as_noise_of_their_size(step: float) -> None:
    """The noise is at least that of the steps and less than twice as large, although some walls give equal readings."""
    found = white(learnt(RangeNoise(0.001, 1.0, 0.001, 0.0), 360, 60, lambda r: np.round(r / step) * step))
    assert step / np.sqrt(12.0) <= found.near < 2.0 * step / np.sqrt(12.0)


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_clutter_is_not_noise(share: float) -> None:
    """Some beams end anywhere on their way to the wall. With the larger share, most far readings are such clutter, and
    nearly all near ones."""
    random = np.random.default_rng(3)

    def cluttered(ranges: FloatArray) -> FloatArray:
        hit = np.repeat(random.random(len(ranges) // 4) < share, 4)
        return np.where(hit, ranges * random.uniform(0.2, 1.0, len(ranges)), ranges)

    found = learnt(RangeNoise(0.01, 1.0, 0.01, 0.0), 360, 60, cluttered)
    assert found.far == pytest.approx(0.01, rel=0.1)
    assert found.near < 0.02


def test_clutter_alone_stays_within_the_bound() -> None:
    learner, random = LearntNoise.start(), np.random.default_rng(4)
    for _ in range(60):
        noise = learner.observe(scan_of(random.uniform(0.3, 10.0, 360)))
    assert noise.near < 0.05
    assert noise.far < 0.04
    assert np.isfinite(noise.sigma(RATIOS)).all()


@given(st.sampled_from(list(FAMILIES)), st.integers(0, 59), st.floats(-np.pi, np.pi))
def test_turning_and_mirroring_the_sensor_change_nothing(family: str, seed: int, angle: float) -> None:
    scan = make_scene(family, seed, "spec/3").scan
    turned = replace(scan, angle_min=scan.angle_min + angle)
    mirrored = replace(scan, angle_min=scan.angle_max, angle_increment=-scan.angle_increment, ranges=scan.ranges[::-1])
    plain = LearntNoise.start().observe(scan)
    np.testing.assert_allclose(LearntNoise.start().observe(turned), plain, rtol=0.01)
    np.testing.assert_allclose(LearntNoise.start().observe(mirrored), plain, rtol=0.01)


def test_a_world_twice_as_large_has_twice_the_noise() -> None:
    """The learner starts without counts. Doubling the world shifts all its bands and bins by an octave."""
    found, r = [], np.array([1.5, 3.0])
    for scale in (1.0, 2.0):
        learner = LearntNoise(np.zeros_like(LearntNoise.start().counts))
        random = np.random.default_rng(5)
        for _ in range(5):
            ranges = room(682, random)
            ranges = ranges * (1.0 + 0.01 * random.standard_normal(682))
            noise = learner.observe(scan_of(scale * ranges, 0.0, 2.0 * np.pi / 682))
        found.append(white(noise).sigma(scale * r) / scale)
    np.testing.assert_allclose(*found, rtol=0.05)


def test_a_wrong_sensor_model_is_corrected_within_seconds() -> None:
    """The true noise is three times that of the named sensor, or a third of it; it is learnt from five scans."""
    for sigmas in (1.0, 9.0):
        learner = LearntNoise.start(ChiSquareConfig(sensor="urg04lx"))
        assert learner.noise.far == pytest.approx(0.025 / 3.0, rel=0.2)
        random = np.random.default_rng(6)
        for _ in range(5):
            ranges = room(682, random)
            ranges = ranges * (1.0 + 0.025 / sigmas * random.standard_normal(682))
            found = learner.observe(scan_of(ranges, 0.0, 2.0 * np.pi / 682))
        assert found.far == pytest.approx(0.025 / sigmas, rel=0.1)


@pytest.mark.parametrize("ranges", [np.empty(0), np.full(682, np.inf), np.full(682, np.nan), np.ones(2)])
def test_learned_noise_is_kept_over_scans_without_echo(ranges: FloatArray) -> None:
    learner = LearntNoise.start()
    before = learner.observe(make_scene("room", 1, "spec").scan)
    for _ in range(100):
        assert learner.observe(scan_of(ranges)) == before


def test_the_same_scans_give_the_same_noise() -> None:
    scans = [make_scene("clutter", seed, "spec/3").scan for seed in range(5)]
    one, other = LearntNoise.start(), LearntNoise.start()
    assert [one.observe(scan) for scan in scans] == [other.observe(scan) for scan in scans]
    assert np.array_equal(one.counts, other.counts)


def test_counts_are_those_of_a_plain_reference() -> None:
    scan = make_scene("office", 2, "spec/3").scan
    learner = LearntNoise(np.zeros_like(LearntNoise.start().counts))
    learner.observe(scan)
    r = scan.ranges[scan.echoes]
    t = scan.bearings[scan.echoes]
    step, before, u = np.diff(t)[1:], np.diff(t)[:-1], 1.0 / r
    sizes = np.abs(u[:-2] - 2.0 * np.cos(step) * u[1:-1] + u[2:]) * r[1:-1] ** 2 / np.sqrt(6.0)
    used = np.abs(step - before) < 0.1 * step
    expected = np.zeros_like(learner.counts)
    bands = np.floor(2.0 * np.log2(r[1:-1] / NEAREST))
    places = np.floor(OCTAVE * np.log2(sizes / SMALLEST / np.maximum(NEAREST * 2.0 ** (bands / 2.0), 1.0)))
    used &= (bands >= 0) & (places >= 0) & (places < SIZES)
    np.add.at(expected, (bands[used].astype(int), places[used].astype(int)), 1.0)
    np.testing.assert_array_equal(learner.counts, expected)
