"""The project's own line extraction: laws, a plain reference, and effects of real sensors."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from slam.bench.floor_plans import FAMILIES
from slam.bench.line_score import score_lines, total_score
from slam.bench.scenes import TUNING_SEEDS, make_scene
from slam.config import ChiSquareConfig, SlamConfig
from slam.lidars import URG04LX
from slam.line_slam import LineSlam
from slam.lines.beam_sums import SUMS, chi_square, prefix_sums
from slam.lines.chi_square import segments_by_chi_square
from slam.lines.facets import facets_of
from slam.lines.range_noise import noise_of_sensor
from slam.lines.segments import Segments
from slam.lines.wall_runs import wall_runs
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan, even_fan

LIDAR = URG04LX.lidar
FAN = even_fan(LIDAR.angle_min, LIDAR.angle_increment, LIDAR.beams)
KNOWN = ChiSquareConfig(sensor="urg04lx", bound_sigmas=3.0)
families = st.sampled_from(list(FAMILIES))
seeds = st.integers(0, 59)


def scan_of(ranges: FloatArray, angle_min: float = LIDAR.angle_min, step: float = LIDAR.angle_increment) -> LaserScan:
    return LaserScan(0.0, angle_min, step, LIDAR.range_min, LIDAR.range_max, ranges)


def flat_wall(distance: float = 1.5, noise: float = 0.0, seed: int = 0) -> FloatArray:
    """Ranges to a wall straight ahead, beams 200 to 480; no echo beside it."""
    ranges = np.full(LIDAR.beams, np.inf)
    ranges[200:481] = distance / np.cos(LIDAR.angles[200:481])
    return ranges + noise * np.random.default_rng(seed).standard_normal(LIDAR.beams)


def inverse_range_errors(ab: FloatArray, t: FloatArray, r: FloatArray, sigma: FloatArray) -> FloatArray:
    return (ab[0] * np.cos(t) + ab[1] * np.sin(t) - 1 / r) * r**2 / sigma


def same(a: Segments, b: Segments) -> None:
    np.testing.assert_allclose(a.rho, b.rho, atol=1e-9)
    np.testing.assert_allclose(a.normals, b.normals, atol=1e-9)
    np.testing.assert_allclose(a.start, b.start, atol=1e-9)
    np.testing.assert_allclose(a.end, b.end, atol=1e-9)


@given(families, seeds, st.floats(-np.pi, np.pi))
def test_turning_the_sensor_turns_the_segments(family: str, seed: int, angle: float) -> None:
    ranges = make_scene(family, seed, "spec/3").scan.ranges
    plain = segments_by_chi_square(scan_of(ranges), KNOWN)
    turned = segments_by_chi_square(scan_of(ranges, LIDAR.angle_min + angle), KNOWN)
    same(plain.transformed(Pose2D(theta=angle)), turned)


@given(families, seeds)
def test_segments_are_runs_in_order_that_never_share_a_point(family: str, seed: int) -> None:
    scene = make_scene(family, seed, "spec")
    segments = segments_by_chi_square(scene.scan, KNOWN)
    assert (segments.last[:-1] < segments.first[1:]).all()
    assert (segments.counts >= KNOWN.min_points).all()
    assert (segments.rho >= 0).all()
    assert segments.last.max(initial=0) < len(scene.scan.points())


@given(families, seeds)
def test_a_line_is_that_of_a_general_solver(family: str, seed: int) -> None:
    """The plain reference: least squares of 1/r over the beams of each segment, by scipy."""
    scan = make_scene(family, seed, "spec/3").scan
    noise = noise_of_sensor("urg04lx", 3.0)
    segments = segments_by_chi_square(scan, KNOWN, noise)
    r, t = scan.ranges[scan.echoes], LIDAR.angles[scan.echoes]
    for m in range(len(segments)):
        at = slice(segments.first[m], segments.last[m] + 1)
        fit = least_squares(inverse_range_errors, [1.0, 1.0], args=(t[at], r[at], noise.sigma(r[at])))
        normal = fit.x / np.hypot(*fit.x)
        np.testing.assert_allclose(segments.rho[m], 1 / np.hypot(*fit.x), rtol=1e-5)
        np.testing.assert_allclose(segments.normals[m], normal, atol=1e-5)


@given(families, seeds, st.integers(0, 600), st.integers(3, 80))
def test_prefix_sums_give_the_chi_square_of_any_run(family: str, seed: int, begin: int, count: int) -> None:
    scan, noise = make_scene(family, seed, "spec/3").scan, noise_of_sensor("urg04lx", 3.0)
    N = LIDAR.beams
    sums, beam, after_gap = np.empty((N + 1, SUMS)), np.empty(N, np.int64), np.empty(N + 1, np.bool_)
    n = prefix_sums(scan.ranges, FAN, (scan.range_min, scan.range_max), noise, sums, beam, after_gap)
    assert n == scan.echoes.sum()
    begin = min(begin, n - 3)
    stop = min(begin + count, n)
    r, t = scan.ranges[beam[begin:stop]], LIDAR.angles[beam[begin:stop]]
    weight = r * r / noise.sigma(r)
    A = weight[:, None] * np.column_stack([np.cos(t), np.sin(t)])
    b = weight / r
    residual = A @ np.linalg.lstsq(A, b, rcond=None)[0] - b
    assert chi_square(sums, begin, stop) == pytest.approx(residual @ residual, rel=1e-4, abs=1e-2)


def test_the_tuning_scenes_meet_their_limits() -> None:
    """A tenth of the tuning scenes shows if extraction gets worse; ``hopslam bench lines`` scores held-out scenes."""
    for level, sigmas, bar in (("spec/19", 19.0, 0.98), ("spec/3", 3.0, 0.96), ("spec", 1.0, 0.85)):
        config = ChiSquareConfig(sensor="urg04lx", bound_sigmas=sigmas)
        found = [make_scene(family, seed, level) for family in FAMILIES for seed in TUNING_SEEDS[::10]]
        score = total_score([score_lines(scene.walls, segments_by_chi_square(scene.scan, config)) for scene in found])
        assert score.f1 > bar, level


@pytest.mark.parametrize("config", [KNOWN, ChiSquareConfig()])
def test_a_wall_is_one_segment(config: ChiSquareConfig) -> None:
    segments = segments_by_chi_square(scan_of(flat_wall(noise=0.008)), config)
    assert len(segments) == 1
    assert segments.rho[0] == pytest.approx(1.5, abs=0.01)
    assert segments.theta[0] == pytest.approx(0.0, abs=0.02)
    np.testing.assert_allclose(segments.start[0, 1], 1.5 * np.tan(LIDAR.angles[200]), atol=0.02)


@pytest.mark.parametrize("lost", [np.inf, -np.inf, np.nan, 0.0, 9.0])
def test_beams_without_echo_and_errors_are_left_out(lost: float) -> None:
    """Single lost beams do not divide a wall; ``first`` and ``last`` count the beams with an echo."""
    ranges = flat_wall()
    ranges[[250, 300, 301, 411]] = lost
    segments = segments_by_chi_square(scan_of(ranges), KNOWN)
    assert segments.first.tolist() == [0]
    assert segments.last.tolist() == [276]
    assert segments.rho[0] == pytest.approx(1.5)


def test_unlimited_reach_keeps_every_echo() -> None:
    ranges = 2.0 / np.cos(np.clip(LIDAR.angles, -1.2, 1.2))
    ranges[::7] = np.inf
    limited, unlimited = (replace(scan_of(ranges), range_max=far) for far in (1e6, np.inf))
    found = [segments_by_chi_square(scan, ChiSquareConfig()) for scan in (limited, unlimited)]
    assert np.array_equal(found[0].rho, found[1].rho)
    assert len(facets_of(unlimited, found[1], 0.2)) == len(facets_of(limited, found[0], 0.2)) > 0


def test_a_gap_without_echo_separates_two_walls() -> None:
    ranges = flat_wall()
    ranges[300:380] = np.inf
    ranges[380:] *= 1.3
    segments = segments_by_chi_square(scan_of(ranges), KNOWN)
    assert segments.counts.tolist() == [100, 101]


def test_mixed_pixels_belong_to_no_wall() -> None:
    """Beams that are half on the near wall and half on the far one read something between the two."""
    ranges = flat_wall(3.0)
    ranges[200:340] = 1.0 / np.cos(LIDAR.angles[200:340])
    ranges[338:342] = [1.25, 1.7, 2.3, 2.8]
    segments = segments_by_chi_square(scan_of(ranges), KNOWN, noise_of_sensor("urg04lx", 3.0))
    assert len(segments) == 2
    np.testing.assert_allclose(segments.rho, [1.0, 3.0], atol=2e-3)
    np.testing.assert_allclose(segments.end[0], [1.0, np.tan(LIDAR.angles[337])], atol=0.01)
    np.testing.assert_allclose(segments.start[1], [3.0, 3.0 * np.tan(LIDAR.angles[342])], atol=0.03)


def test_a_fan_may_turn_clockwise() -> None:
    ranges = make_scene("office", 1, "spec/3").scan.ranges
    forth = segments_by_chi_square(scan_of(ranges), KNOWN)
    back = segments_by_chi_square(scan_of(ranges[::-1].copy(), LIDAR.angle_max, -LIDAR.angle_increment), KNOWN)
    assert abs(len(forth) - len(back)) <= 1


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_a_tiny_scan_gives_no_segment(count: int) -> None:
    for config in (KNOWN, ChiSquareConfig()):
        segments = segments_by_chi_square(scan_of(np.ones(count)), config)
        assert len(segments) == 0
        assert segments.start.shape == (0, 2)


def test_coincident_beams_do_no_harm() -> None:
    for bearings in (np.zeros(40), np.repeat(np.linspace(-0.5, 0.5, 20), 2)):
        fan = np.stack([bearings, np.cos(bearings), np.sin(bearings)])
        scan = LaserScan(0.0, 0.0, 0.1, 0.06, 4.0, 1 / np.cos(bearings), beam_fan=fan)
        segments = segments_by_chi_square(scan, KNOWN)
        assert np.isfinite(segments.rho).all()
    assert segments.rho[0] == pytest.approx(1.0)


def test_a_sick_lidar_needs_no_other_settings() -> None:
    """180 degrees, one beam a degree, centimetre steps, 80 m: the corner of a hall."""
    angles = np.radians(np.arange(181.0) - 90.0)
    with np.errstate(divide="ignore"):
        walls = np.stack([12.0 / np.cos(angles), np.where(angles > 0, 7.0 / np.sin(np.abs(angles)), np.inf)])
    ranges = np.round(walls.min(axis=0) + 0.01 * np.random.default_rng(2).standard_normal(181), 2)
    scan = LaserScan(0.0, angles[0], np.radians(1.0), 0.05, 80.0, np.where(ranges < 40.0, ranges, np.inf))
    segments = segments_by_chi_square(scan, ChiSquareConfig())
    assert len(segments) == 2
    np.testing.assert_allclose(np.sort(segments.rho), [7.0, 12.0], atol=0.02)
    np.testing.assert_allclose(segments.end[0], [12.0, 7.0], atol=0.05)


def test_runs_do_not_depend_on_other_runs() -> None:
    """wall_runs looks at nothing but its arguments: the same bits twice."""
    scan = make_scene("clutter", 2, "spec/3").scan
    noise = noise_of_sensor("urg04lx", 3.0)
    once, again = (wall_runs(scan.ranges, FAN, (0.06, 4.0), noise, 18.0, 7) for _ in range(2))
    np.testing.assert_array_equal(once[0], again[0])
    np.testing.assert_array_equal(once[1], again[1])


def test_line_slam_runs_with_chi_square() -> None:
    slam = LineSlam(SlamConfig(lines=ChiSquareConfig()), Pose2D())
    for stamp in (0.0, 0.1):
        estimate = slam.update(make_scene("room", 5, "spec/19").scan, Odometry(stamp, Pose2D()))
    assert estimate.T_map_base.distance(Pose2D()) < 0.05
    assert estimate.segments is not None
    assert estimate.segments.covariance is not None
