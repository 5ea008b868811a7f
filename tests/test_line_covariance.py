"""The covariances of lines and ends match their errors in every frame."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from slam.config import ChiSquareConfig
from slam.lidars import URG04LX
from slam.lines.chi_square import segments_by_chi_square, segments_of_scans
from slam.lines.range_noise import noise_of_sensor
from slam.lines.segments import Segments
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

LIDAR = URG04LX.lidar
CONFIG = ChiSquareConfig(sensor="urg04lx", bound_sigmas=6.0)
NOISE = noise_of_sensor("urg04lx", 6.0)._replace(floor=0.0003)  # of walls that are flat


def corner_ranges(rho_1: float, theta_1: float, rho_2: float, theta_2: float) -> FloatArray:
    """Ranges to the nearer of two lines, no echo where neither is within 3.5 m."""
    ranges = np.full(LIDAR.beams, np.inf)
    for rho, theta in ((rho_1, theta_1), (rho_2, theta_2)):
        facing = np.cos(LIDAR.angles - theta)
        ranges = np.minimum(ranges, np.where(facing > 0.2, rho / np.maximum(facing, 0.2), np.inf))
    return np.where(ranges < 3.5, ranges, np.inf)


def scan_of(ranges: FloatArray) -> LaserScan:
    return LaserScan(0.0, LIDAR.angle_min, LIDAR.angle_increment, LIDAR.range_min, LIDAR.range_max, ranges)


def normalised(error: FloatArray, covariance: FloatArray) -> FloatArray:
    """Squared Mahalanobis length of each error (N, 2)."""
    return np.einsum("ni,nij,nj->n", error, np.linalg.inv(covariance), error)


def test_covariances_of_lines_and_corners_fit_their_errors() -> None:
    """10,000 noisy looks at a corner: the truth lies within the 95 % bound 93 to 97 times in a hundred."""
    truth = np.array([[1.6, -0.2], [1.2, 1.1]])
    clean = corner_ranges(*truth.ravel())
    random = np.random.default_rng(5)
    noisy = clean + NOISE.sigma(np.minimum(clean, 4.0)) * random.standard_normal((10_000, LIDAR.beams))
    segments, begins = segments_of_scans([scan_of(ranges) for ranges in noisy], CONFIG, NOISE)
    assert (np.diff(begins) == 2).mean() > 0.99
    pairs = begins[:-1][np.diff(begins) == 2]
    corner = np.linalg.solve(np.column_stack([np.cos(truth[:, 1]), np.sin(truth[:, 1])]), truth[:, 0])
    bound = chi2.ppf(0.95, 2)
    assert segments.covariance is not None
    assert segments.end_covariance is not None
    for which in range(2):
        error = np.column_stack([segments.rho, segments.theta])[pairs + which] - truth[which]
        within = normalised(error, segments.covariance[pairs + which]) < bound
        assert 0.93 < within.mean() < 0.97
    within = normalised(segments.end[pairs] - corner, segments.end_covariance[pairs]) < bound
    assert 0.93 < within.mean() < 0.97


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-np.pi, np.pi))
def test_covariances_follow_a_change_of_frame(x: float, y: float, theta: float) -> None:
    """The expected covariance uses the Jacobian of the transformation by central differences."""
    segments = segments_by_chi_square(scan_of(corner_ranges(1.6, -0.2, 1.2, 1.1)), CONFIG)
    T = Pose2D(x, y, theta)
    moved = segments.transformed(T)
    assert moved.covariance is not None
    assert segments.covariance is not None
    for m in range(len(segments)):
        jacobian = np.empty((2, 2))
        for column in range(2):
            step = 1e-6 * np.eye(2)[column]
            ahead, behind = (nudged(segments, sign * step).transformed(T) for sign in (1, -1))
            jacobian[:, column] = [ahead.rho[m] - behind.rho[m], ahead.theta[m] - behind.theta[m]]
        jacobian /= 2e-6
        np.testing.assert_allclose(
            moved.covariance[m], jacobian @ segments.covariance[m] @ jacobian.T, rtol=1e-4, atol=1e-12
        )


def nudged(segments: Segments, step: FloatArray) -> Segments:
    return Segments(
        segments.first, segments.last, segments.rho + step[0], segments.theta + step[1], segments.start, segments.end
    )


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-np.pi, np.pi))
def test_a_motion_and_its_inverse_cancel(x: float, y: float, theta: float) -> None:
    segments = segments_by_chi_square(scan_of(corner_ranges(1.6, -0.2, 1.2, 1.1)), CONFIG)
    back = segments.transformed(Pose2D(x, y, theta)).transformed(Pose2D(x, y, theta).inverse())
    for name in ("rho", "start", "end", "covariance", "start_covariance", "end_covariance"):
        np.testing.assert_allclose(getattr(back, name), getattr(segments, name), atol=1e-9)


def test_segments_without_covariance_get_none() -> None:
    line = np.zeros(1)
    plain = Segments(np.zeros(1, int), np.ones(1, int), line, line, np.zeros((1, 2)), np.ones((1, 2)))
    assert plain.transformed(Pose2D(1.0, 2.0, 3.0)).covariance is None


def test_many_scans_at_once_are_the_same_as_one_by_one() -> None:
    random = np.random.default_rng(3)
    clean = corner_ranges(1.6, -0.2, 1.2, 1.1)
    noisy = clean + NOISE.sigma(np.minimum(clean, 4.0)) * random.standard_normal((20, LIDAR.beams))
    scans = [scan_of(ranges) for ranges in noisy]
    together, begins = segments_of_scans(scans, CONFIG, NOISE)
    assert begins[-1] == len(together)
    for i, scan in enumerate(scans):
        alone, at = segments_by_chi_square(scan, CONFIG, NOISE), slice(begins[i], begins[i + 1])
        for name in set(Segments.__dataclass_fields__) - {"noise"}:
            np.testing.assert_array_equal(getattr(together, name)[at], getattr(alone, name))
