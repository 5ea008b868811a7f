"""The line extractors used for comparison, on walls with known segments."""

import sys
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.bench.log_score import distances_to_segments
from slam.bench.probabilistic_hough import ProbabilisticHough
from slam.bench.ransac import Ransac
from slam.bench.split_and_merge import SplitAndMerge, fitted_line
from slam.errors import InputError
from slam.lidars import URG04LX
from slam.lines.hough_line import hough_line
from slam.lines.segments import Segments
from slam.pose import FloatArray
from slam.scan import LaserScan

EXTRACTORS = [SplitAndMerge(), Ransac(), ProbabilisticHough()]


def scan_of(ranges: FloatArray) -> LaserScan:
    lidar = URG04LX.lidar
    return LaserScan(0.0, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max, ranges)


def corner_scan(noise: float = 0.0) -> LaserScan:
    """Walls at x = 2 and y = -1.5, which meet at (2, -1.5); the first is seen to (2, 2), the second from (0, -1.5)."""
    angles = URG04LX.lidar.angles
    with np.errstate(divide="ignore"):
        ranges = np.minimum(2.0 / np.cos(angles), np.where(angles < 0, -1.5 / np.sin(angles), np.inf))
    ranges[(angles > np.pi / 4) | (angles < -np.pi / 2)] = np.inf
    return scan_of(ranges + np.random.default_rng(0).normal(0.0, noise, len(ranges)))


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_split_and_merge_finds_a_corner(noise: float) -> None:
    segments = SplitAndMerge()(corner_scan(noise))
    np.testing.assert_allclose(segments.start, [[0.0, -1.5], [2.0, -1.5]], atol=0.01 + 8 * noise)
    np.testing.assert_allclose(segments.end, [[2.0, -1.5], [2.0, 2.0]], atol=0.01 + 8 * noise)
    np.testing.assert_allclose(segments.rho, [1.5, 2.0], atol=0.001 + noise)
    np.testing.assert_allclose(segments.theta, [-np.pi / 2, 0.0], atol=0.001 + 2 * noise)
    assert segments.last[0] == segments.first[1]


def test_split_and_merge_does_not_bridge_a_gap() -> None:
    """A wall at x = 2 with a door of 0.4 m in it."""
    angles = URG04LX.lidar.angles
    with np.errstate(divide="ignore"):
        ranges = 2.0 / np.cos(angles)
    ranges[(np.abs(angles) > np.pi / 4) | (np.abs(2.0 * np.tan(angles)) < 0.2)] = np.inf
    segments = SplitAndMerge()(scan_of(ranges))
    np.testing.assert_allclose(segments.start, [[2.0, -2.0], [2.0, 0.2]], atol=0.02)
    np.testing.assert_allclose(segments.end, [[2.0, -0.2], [2.0, 2.0]], atol=0.02)


@pytest.mark.parametrize("extractor", EXTRACTORS)
def test_every_extractor_finds_both_walls(extractor: Callable[[LaserScan], Segments]) -> None:
    if not isinstance(extractor, SplitAndMerge):
        pytest.importorskip("skimage")
        pytest.importorskip("cv2")
    segments = extractor(corner_scan(noise=0.002))
    for rho, normal in ((1.5, [0.0, -1.0]), (2.0, [1.0, 0.0])):
        near = (np.abs(segments.rho - rho) < 0.05) & (segments.normals @ normal > 0.998)
        assert near.any()
    assert (segments.first < segments.last).all()
    for ends in (segments.start, segments.end):
        np.testing.assert_allclose(np.sum(segments.normals * ends, axis=1), segments.rho, atol=1e-9)


@pytest.mark.parametrize("extractor", EXTRACTORS)
@pytest.mark.parametrize("echoes", [0, 1, 2, 5])
def test_few_echoes_give_no_segment(extractor: Callable[[LaserScan], Segments], echoes: int) -> None:
    pytest.importorskip("skimage")
    pytest.importorskip("cv2")
    ranges = np.full(URG04LX.lidar.beams, np.inf)
    ranges[300 : 300 + echoes] = 1.0
    segments = extractor(scan_of(ranges))
    assert len(segments) == 0
    assert segments.start.shape == (0, 2)


@given(st.floats(-np.pi, np.pi), st.floats(0.1, 4.0))
def test_the_fitted_line_of_exact_points_is_the_hough_line(theta: float, rho: float) -> None:
    along = np.linspace(-1.0, 1.0, 20)[:, None] * [-np.sin(theta), np.cos(theta)]
    points = rho * np.array([np.cos(theta), np.sin(theta)]) + along
    found_rho, found_theta = fitted_line(points, 0, 19)
    expected = hough_line(points)
    assert found_rho == pytest.approx(expected.rho)
    assert np.cos(found_theta - expected.theta) == pytest.approx(1.0)


def test_the_distance_is_that_to_the_nearest_segment() -> None:
    """One segment from (0, 0) to (2, 0): beside it, beyond its end, and none at all."""
    start, end = np.zeros((1, 2)), np.array([[2.0, 0.0]])
    points = np.array([[1.0, 0.5], [5.0, 4.0], [-3.0, 4.0]])
    np.testing.assert_allclose(distances_to_segments(points, start, end), [0.5, 5.0, 5.0])
    assert np.isinf(distances_to_segments(points, np.empty((0, 2)), np.empty((0, 2)))).all()


@pytest.mark.parametrize(("extractor", "module"), [(Ransac(), "skimage.measure"), (ProbabilisticHough(), "cv2")])
def test_a_missing_package_is_named(
    extractor: Callable[[LaserScan], Segments], module: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=r"pip install 'hopslam\[bench\]'"):
        extractor(corner_scan())
