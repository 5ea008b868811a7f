"""Line extraction: laws, then known answers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from slam.config import HoppingConfig
from slam.lines.hopping import hop_by_svd, segments_by_hopping
from slam.lines.hough_line import hough_line
from slam.lines.segments import Segments
from slam.pose import FloatArray, Pose2D

seeds = st.integers(0, 2**32 - 1)


def noisy_walls(seed: int, beams: int = 120, noise: float = 0.005) -> FloatArray:
    """A scan of straight walls with corners, jumps and outliers, in beam order, metres."""
    random = np.random.default_rng(seed)
    corners = np.cumsum(random.uniform(-1.5, 1.5, (6, 2)), axis=0) + random.uniform(-2, 2, 2)
    along = np.linspace(0, len(corners) - 1 - 1e-9, beams)
    wall, share = along.astype(int), (along % 1)[:, None]
    points = corners[wall] * (1 - share) + corners[wall + 1] * share
    points[random.random(beams) < 0.02] += random.normal(0, 0.5, 2)
    return np.ascontiguousarray(points + random.normal(0, noise, (beams, 2)))


KERNELS = ("svd_full", "svd", "prefix_sums")


def all_kernels(points: FloatArray, **settings: float) -> tuple[Segments, ...]:
    return tuple(
        segments_by_hopping(points, HoppingConfig.model_validate({"kernel": kernel, **settings})) for kernel in KERNELS
    )


def same_segments(a: Segments, b: Segments) -> None:
    np.testing.assert_array_equal(a.first, b.first)
    np.testing.assert_array_equal(a.last, b.last)
    np.testing.assert_array_equal(a.start, b.start)
    np.testing.assert_array_equal(a.end, b.end)
    np.testing.assert_allclose(a.rho, b.rho, atol=1e-6)
    np.testing.assert_allclose(a.normals, b.normals, atol=1e-6)


@given(
    seeds,
    st.integers(0, 5),
    st.sampled_from([0.01, 25 / 1024, 0.1]),
    st.sampled_from([0.3, float("inf")]),
    st.booleans(),
    st.floats(-np.pi, np.pi),
)
def test_all_kernels_give_the_same_segments(
    seed: int, psi: int, sigma_Th: float, split_gap: float, backwards: bool, angle: float
) -> None:
    points = Pose2D(theta=angle).transform(noisy_walls(seed, beams=80))
    points = points[::-1] if backwards else points
    full, svd, sums = all_kernels(points, psi=psi, L_Th=11, sigma_Th=sigma_Th, split_gap=split_gap)
    same_segments(full, svd)
    same_segments(svd, sums)


@given(seeds, st.lists(st.tuples(st.integers(0, 79), st.sampled_from([np.nan, np.inf, -np.inf])), max_size=9))
def test_points_that_are_not_finite_are_left_out(seed: int, bad: list[tuple[int, float]]) -> None:
    points = noisy_walls(seed, beams=80)
    for at, value in bad:
        points[at, at % 2] = value
    finite = points[np.isfinite(points).all(axis=1)]
    for segments, expected in zip(all_kernels(points), all_kernels(finite), strict=True):
        same_segments(segments, expected)


@given(seeds, st.integers(1, 4))
def test_repeated_points_do_no_harm(seed: int, times: int) -> None:
    """All kernels find the same segments, and their numbers are finite."""
    full, svd, sums = all_kernels(np.repeat(noisy_walls(seed, beams=40), times, axis=0), L_Th=11)
    same_segments(full, svd)
    same_segments(svd, sums)
    assert np.isfinite(sums.rho).all()


@given(seeds, st.integers(1, 8))
def test_hopping_changes_no_segment(seed: int, psi: int) -> None:
    """sigma_3 cannot fall when a point is added, so a hop never jumps over an end."""
    points = noisy_walls(seed)
    assert hop_by_svd(points, 25 / 1024, psi) == hop_by_svd(points, 25 / 1024, 0)


@given(seeds, st.floats(-np.pi, np.pi))
def test_rotating_a_scan_rotates_its_segments(seed: int, angle: float) -> None:
    points = noisy_walls(seed)
    plain = segments_by_hopping(points, HoppingConfig()).transformed(Pose2D(theta=angle))
    turned = segments_by_hopping(Pose2D(theta=angle).transform(points), HoppingConfig())
    np.testing.assert_array_equal(plain.first, turned.first)
    np.testing.assert_allclose(plain.rho, turned.rho, atol=1e-6)
    np.testing.assert_allclose(plain.normals, turned.normals, atol=1e-6)


@given(seeds)
def test_a_line_is_the_same_in_reverse_order(seed: int) -> None:
    points = noisy_walls(seed, beams=40)[:10]
    there, back = hough_line(points), hough_line(points[::-1])
    np.testing.assert_allclose(there, back, atol=1e-9)


@given(seeds, st.floats(-3, 3), st.floats(-3, 3), st.floats(-np.pi, np.pi))
def test_transforming_a_segment_keeps_its_ends_on_its_line(seed: int, x: float, y: float, theta: float) -> None:
    segments = segments_by_hopping(noisy_walls(seed, noise=0.0), HoppingConfig()).transformed(Pose2D(x, y, theta))
    for ends in (segments.start, segments.end):
        off_line = np.sum(segments.normals * ends, axis=1) - segments.rho
        assert np.abs(off_line).max(initial=0.0) < 0.1


@pytest.mark.parametrize("theta", np.radians([0.0, 30.0, 90.0, 135.0, 180.0, -100.0]))
def test_a_known_line_is_found(theta: float) -> None:
    along = np.linspace(-1, 1, 9)[:, None] * [-np.sin(theta), np.cos(theta)]
    line = hough_line(1.7 * np.array([np.cos(theta), np.sin(theta)]) + along)
    assert line.rho == pytest.approx(1.7)
    np.testing.assert_allclose([np.cos(line.theta), np.sin(line.theta)], [np.cos(theta), np.sin(theta)], atol=1e-12)
    assert line.sigma_3 < 1e-12


@pytest.mark.parametrize("psi", [0, 1, 2, 5])
def test_a_corner_gives_two_segments_that_share_their_point(psi: int) -> None:
    """Proc. 6: the next segment starts at the end of the last; the last one reaches the end of the scan."""
    leg = np.linspace(0.0, 2.0, 21)
    points = np.concatenate(
        [np.column_stack([leg - 2, np.full(21, 1.0)]), np.column_stack([np.zeros(20), 1 - leg[1:]])]
    )
    for segments in all_kernels(points, psi=psi, L_Th=11):
        assert segments.first.tolist() == [0, 20]
        assert segments.last.tolist() == [20, 40]
        np.testing.assert_allclose(segments.start, [[-2, 1], [0, 1]])
        np.testing.assert_allclose(segments.end, [[0, 1], [0, -1]])


def test_short_segments_are_dropped() -> None:
    """Proc. 7: more than L_Th points are kept, exactly L_Th are not."""
    line = np.column_stack([np.arange(7.0), np.ones(7)])
    assert len(segments_by_hopping(line, HoppingConfig(L_Th=6))) == 1
    assert len(segments_by_hopping(line, HoppingConfig(L_Th=7))) == 0


def test_a_gap_splits_a_line_if_enabled() -> None:
    x = np.concatenate([np.arange(0, 1, 0.05), np.arange(2, 3, 0.05)])
    wall = np.column_stack([x, np.ones_like(x)])
    for segments in all_kernels(wall, split_gap=0.5):
        assert segments.first.tolist() == [0, 20]
        assert segments.last.tolist() == [19, 39]
    assert len(segments_by_hopping(wall, HoppingConfig())) == 1


@pytest.mark.parametrize("count", [0, 1, 2])
def test_too_few_points_give_no_segment(count: int) -> None:
    for segments in all_kernels(np.ones((count, 2))):
        assert len(segments) == 0
        assert segments.start.shape == (0, 2)


def test_coincident_points_do_no_harm() -> None:
    for segments in all_kernels(np.full((20, 2), 1.5)):
        assert np.isfinite(segments.rho).all()
        assert (segments.counts > 4).all()


def test_a_hop_beyond_the_segment_is_refused() -> None:
    with pytest.raises(ValidationError, match="over-hops"):
        HoppingConfig(psi=3, L_Th=6)
