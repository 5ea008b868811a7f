"""The project's own matcher and map, on scans of simple rooms."""

from dataclasses import replace
from itertools import pairwise
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from slam.config import SlamConfig, SurfelMapConfig
from slam.deskew import deskewed
from slam.line_slam import Estimate, LineSlam
from slam.lines.extraction import extract_segments
from slam.lines.facets import COUNT, NX, NY, X, Y, facets_of
from slam.mapping.map_uncertainty import MapUncertainty
from slam.mapping.surfel_map import SurfelMap
from slam.matching.normal_equations import SHIFT_SIGMA, _free_shift
from slam.motion_model import propagate
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

BEARINGS = np.linspace(-2.0, 2.0, 401)
ROOM = np.array([[-3, -2], [4, -2], [4, 0], [6, 0], [6, 3], [-3, 3], [-3, -2]], float)
CORRIDOR = np.array([[-100, -1], [100, -1], [100, 1], [-100, 1], [-100, -1]], float)


def ranges_in(corners: FloatArray, pose: Pose2D, bearings: FloatArray = BEARINGS, reach: float = 8.0) -> FloatArray:
    """Return the ranges from a pose to the walls between these corners."""
    start, along = corners[:-1] - pose.translation, np.diff(corners, axis=0)
    d = np.stack([np.cos(bearings + pose.theta), np.sin(bearings + pose.theta)], axis=1)[:, None]
    cross = d[..., 0] * along[:, 1] - d[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        r = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
        t = (start[:, 0] * d[..., 1] - start[:, 1] * d[..., 0]) / cross
        r = np.where((r > 0) & (t >= 0) & (t <= 1), r, np.inf).min(axis=1)
    return np.asarray(np.where(r < reach, r, np.inf))


def scan_of(corners: FloatArray, pose: Pose2D, noise: float = 0.0, seed: int = 0, stamp: float = 0.0) -> LaserScan:
    ranges = ranges_in(corners, pose) + noise * np.random.default_rng(seed).normal(size=len(BEARINGS))
    return LaserScan(stamp, BEARINGS[0], 0.01, 0.05, 8.0, ranges)


def drive(corners: FloatArray, path: list[Pose2D], wheels: list[Pose2D], noise: float = 0.01) -> list[Estimate]:
    slam = LineSlam(SlamConfig(), Pose2D(), path[0])
    return [
        slam.update(scan_of(corners, pose, noise, k, 0.1 * k), Odometry(0.1 * k, odometry))
        for k, (pose, odometry) in enumerate(zip(path, wheels, strict=True))
    ]


def round_trip(scale: float, steps: int = 40) -> tuple[list[Pose2D], list[Pose2D]]:
    """A path through the room with a turn, and odometry that is off by a factor."""
    path = [Pose2D(0.05 * k, 0.3 * sin(0.1 * k), 0.02 * k) for k in range(steps)]
    wheels = [Pose2D()]
    for a, b in pairwise(path):
        motion = a.between(b)
        wheels.append(wheels[-1] @ Pose2D(scale * motion.x, scale * motion.y, scale * motion.theta))
    return path, wheels


@pytest.mark.parametrize("scale", [1.0, 0.8, 1.2])
def test_the_pose_is_right_whatever_the_odometry(scale: float) -> None:
    path, wheels = round_trip(scale)
    for truth, estimate in zip(path, drive(ROOM, path, wheels), strict=True):
        assert truth.distance(estimate.T_map_base) < 0.02
        assert abs(truth.between(estimate.T_map_base).theta) < np.radians(0.5)
        assert not estimate.lost


@pytest.mark.parametrize("noise", [0.003, 0.05])
def test_a_coarse_sensor_agrees_with_its_map_too(noise: float) -> None:
    """The kernel of a fine sensor is 3 cm, less than a noise of 5 cm; it grows with the learnt noise."""
    path, wheels = round_trip(1.05)
    estimates = drive(ROOM, path, wheels, noise)
    segments, match = estimates[-1].segments, estimates[-1].match
    assert segments is not None
    assert segments.noise is not None
    assert segments.noise.near == pytest.approx(min(noise, 0.044), rel=0.2)
    assert match.inliers > 0.75 * match.points
    assert estimates[-1].T_map_base.distance(path[-1]) < 0.01 + 0.5 * noise


def test_a_jump_of_the_odometry_is_survived() -> None:
    """The odometry jumps by one metre and half a radian at once."""
    path, wheels = round_trip(1.0)
    leap = Pose2D(0.8, -0.6, 0.5)
    run = drive(ROOM, path, [w if k < 20 else wheels[19] @ leap @ wheels[19].between(w) for k, w in enumerate(wheels)])
    for truth, estimate in list(zip(path, run, strict=True))[20:]:
        assert truth.distance(estimate.T_map_base) < 0.03


def test_in_a_bare_corridor_odometry_is_used_and_reported() -> None:
    """The wheels report 3 % too much along the corridor; the walls determine the position across it and the heading."""
    path = [Pose2D(0.05 * k, 0.0, 0.0) for k in range(60)]
    wheels = [Pose2D(1.03 * p.x, 0.02 * p.x, 0.01 * p.x) for p in path]
    run = drive(CORRIDOR, path, wheels)
    for k in range(1, 60):
        assert run[k].T_map_base.x == pytest.approx(1.03 * path[k].x, abs=0.02)
        assert abs(run[k].T_map_base.y) < 0.02
        assert abs(run[k].T_map_base.theta) < np.radians(0.5)
        directions = run[k].unconstrained
        assert directions is not None
        assert len(directions) == 1
        assert abs(directions[0, 0]) > 0.99
    first, last = run[5].covariance, run[-1].covariance
    assert first is not None
    assert last is not None
    assert last[0, 0] > first[0, 0] > 0.0
    assert last[0, 0] > 20.0 * last[1, 1]


def test_the_map_does_not_grow_lap_after_lap() -> None:
    """The noise makes short wrong walls now and then."""
    path = [Pose2D(0.5 + 1.2 * cos(0.1 * k), 0.8 * sin(0.1 * k), 0.1 * k) for k in range(315)]
    start = path[0].inverse()
    run = drive(ROOM, path, [start @ pose for pose in path], 0.03)
    laps = [run[63 * lap - 1].map_points for lap in (3, 4, 5)]
    assert max(laps) <= 1.02 * min(laps)


def test_the_map_does_not_grow_in_a_known_place() -> None:
    path = [Pose2D(0.5 + 0.4 * cos(0.1 * k), 0.4 * sin(0.1 * k), 0.1 * k) for k in range(190)]
    start = path[0].inverse()
    run = drive(ROOM, path, [start @ pose for pose in path])
    assert run[-1].map_points <= 1.05 * run[70].map_points
    assert run[-1].T_map_base.distance(path[-1]) < 0.02


def test_one_wall_is_one_segment() -> None:
    path, wheels = round_trip(1.0)
    slam = LineSlam(SlamConfig(), Pose2D())
    for k, (pose, odometry) in enumerate(zip(path, wheels, strict=True)):
        slam.update(scan_of(ROOM, pose, 0.005, k), Odometry(0.1 * k, odometry))
    ends = slam.lines.ends
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    long = ends[lengths > 1.0]
    middles = long.mean(axis=1)
    assert 4 <= len(long) <= 7
    assert ((np.abs(middles[:, 1] - 3.0) < 0.03).sum()) == 1


def test_moving_objects_are_removed_from_the_map() -> None:
    """Someone stands in the room for 10 scans, and is gone for 20."""
    someone = np.array([[1.5, 0.5], [1.5, 0.9], [1.7, 0.9], [1.7, 0.5], [1.5, 0.5]])
    slam = LineSlam(SlamConfig(loops="never", map=SurfelMapConfig(update_distance=0.0)), Pose2D())

    def near() -> int:
        return int((np.abs(slam.points.points - [1.6, 0.7]).max(axis=1) < 0.3).sum())

    for k in range(30):
        ranges = ranges_in(ROOM, Pose2D())
        if k < 10:
            ranges = np.minimum(ranges, ranges_in(someone, Pose2D()))
        slam.update(LaserScan(0.1 * k, BEARINGS[0], 0.01, 0.05, 8.0, ranges), Odometry(0.1 * k, Pose2D()))
        if k == 9:
            assert near() > 0
    assert near() == 0


def test_a_beam_without_echo_is_only_free_space() -> None:
    blind = LaserScan(0.0, BEARINGS[0], 0.01, 0.05, 8.0, np.full(len(BEARINGS), np.inf))
    slam = LineSlam(SlamConfig(), Pose2D())
    for k in range(3):
        estimate = slam.update(blind, Odometry(0.1 * k, Pose2D(0.1 * k)))
        assert estimate.T_map_base.distance(Pose2D(0.1 * k)) < 1e-9
    assert len(slam.points) == 0


def test_the_same_scans_give_the_same_bits() -> None:
    path, wheels = round_trip(1.1, 15)
    once, again = (drive(ROOM, path, wheels) for _ in range(2))
    assert [e.T_map_base for e in once] == [e.T_map_base for e in again]


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(-0.3, 0.3))
def test_deskewing_undoes_the_motion(v: float, omega: float, mount: float) -> None:
    """A scan taken beam by beam on an arc is the scan at its stamp."""
    T_base_laser, step = Pose2D(mount, 0.05, 0.1), 2e-4
    ranges = np.empty(len(BEARINGS))
    for j in range(len(BEARINGS)):
        turn = omega * step * j
        chord = v * step * j * np.sinc(turn / 2 / pi)
        base = Pose2D(chord * cos(turn / 2), chord * sin(turn / 2), turn)
        ranges[j] = ranges_in(ROOM, base @ T_base_laser, BEARINGS[j : j + 1])[0]
    skewed = LaserScan(0.0, BEARINGS[0], 0.01, 0.05, 8.0, ranges, time_increment=step)
    straight = deskewed(skewed, Twist2D(v, omega), T_base_laser)
    expected = ranges_in(ROOM, T_base_laser, straight.bearings)
    assert np.median(np.abs(straight.ranges - expected)) < 1e-9


def test_a_scan_without_beam_times_is_not_deskewed() -> None:
    scan = scan_of(ROOM, Pose2D())
    assert deskewed(scan, Twist2D(1.0, 1.0), Pose2D()) is scan


def test_facets_lie_on_the_walls_and_face_away() -> None:
    scan = scan_of(ROOM, Pose2D())
    facets = facets_of(scan, extract_segments(scan, SlamConfig().lines), 0.2)
    walls = facets[facets[:, NX] ** 2 + facets[:, NY] ** 2 > 0.0]
    assert facets[:, COUNT].sum() >= 0.98 * scan.echoes.sum()
    assert (walls[:, X] * walls[:, NX] + walls[:, Y] * walls[:, NY] > 0.0).all()
    bearings = np.arctan2(walls[:, Y], walls[:, X])
    off = ranges_in(ROOM, Pose2D(), bearings) - np.hypot(walls[:, X], walls[:, Y])
    assert np.percentile(np.abs(off), 90) < 0.01


def test_surfels_keep_both_sides_of_a_thin_wall_apart() -> None:
    surfels = SurfelMap(SurfelMapConfig())
    scan = scan_of(ROOM, Pose2D())
    for y, side in ((1.00, 1.0), (1.08, -1.0)):
        facet = np.array([[0.1, y, 0.0, side, 1e-5, 10.0, 0.0]])
        surfels.add(facet, scan, Pose2D())
        surfels.add(facet, scan, Pose2D())
    np.testing.assert_allclose(np.sort(surfels.points[:, 1]), [1.00, 1.08], atol=1e-9)


def test_new_facets_count_with_an_unknown_shift() -> None:
    random = np.random.default_rng(0)
    J, w, r = random.normal(size=(6, 3)), random.uniform(1e2, 1e4, 6), random.normal(size=6)
    full = np.column_stack([J, J[:, :2]])  # derivatives by the pose and by the shift
    H = full.T @ (w[:, None] * full) + np.diag([0.0, 0.0, 0.0, *np.full(2, SHIFT_SIGMA**-2)])
    g = -full.T @ (w * r)
    marginal, gradient = J.T @ (w[:, None] * J), -J.T @ (w * r)
    _free_shift(marginal, gradient)
    np.testing.assert_allclose(marginal, H[:3, :3] - H[:3, 3:] @ np.linalg.solve(H[3:, 3:], H[3:, :3]), rtol=1e-9)
    np.testing.assert_allclose(gradient, g[:3] - H[:3, 3:] @ np.linalg.solve(H[3:, 3:], g[3:]), rtol=1e-9)
    assert np.linalg.eigvalsh(np.linalg.inv(marginal))[-1] > SHIFT_SIGMA**2


def test_a_person_walking_along_does_not_shift_the_pose() -> None:
    """The corridor has no ends, so its walls do not constrain the position along it."""
    slam, size = LineSlam(SlamConfig(), Pose2D()), 0.12
    for k in range(100):
        pose, x = Pose2D(0.05 * k), 0.8 + 0.08 * k  # a box at 0.8 m/s, ahead of the robot
        box = np.array([[x, 0.4], [x, 0.4 + size], [x + size, 0.4 + size], [x + size, 0.4], [x, 0.4]])
        ranges = np.minimum(ranges_in(CORRIDOR, pose), ranges_in(box, pose))
        ranges += 0.005 * np.random.default_rng(k).normal(size=len(BEARINGS))
        scan = LaserScan(0.1 * k, BEARINGS[0], 0.01, 0.05, 8.0, ranges)
        slam.update(scan, Odometry(0.1 * k, Pose2D(1.01 * pose.x)))
    assert slam.T_map_base.distance(Pose2D(1.01 * pose.x)) < 0.03


def test_the_map_has_the_uncertainty_of_its_poses() -> None:
    uncertainty, sure, doubtful = MapUncertainty(), np.diag([1e-4, 1e-4, 1e-6]), np.diag([25e-4, 1e-4, 1e-6])
    for x in np.arange(0.0, 12.0, 0.1):
        found = uncertainty.pose_covariance(Pose2D(float(x)), doubtful if 4.5 < x < 5.0 else sure)
    assert found[0, 0] > doubtful[0, 0]
    assert found[1, 1] < doubtful[0, 0]
    np.testing.assert_allclose(uncertainty.pose_covariance(Pose2D(1.0), sure), sure, atol=1e-12)


def test_turning_on_the_spot_does_not_degrade_the_map() -> None:
    uncertainty, match = MapUncertainty(), np.diag([1e-4, 1e-4, 1e-6])
    for k in range(1000):
        uncertainty.pose_covariance(Pose2D(1.9, 0.0, 0.1 * k), match)
    assert np.trace(uncertainty.pose_covariance(Pose2D(2.1), match)) < 2.0 * np.trace(match)


def test_returning_to_a_place_restores_its_covariance() -> None:
    uncertainty, match = MapUncertainty(), np.diag([1e-4, 1e-4, 1e-6])
    there = [uncertainty.pose_covariance(Pose2D(float(x)), match) for x in range(20)]
    assert np.all(np.diff([np.trace(C) for C in there]) >= -1e-12)
    assert there[-1][1, 1] > 3.0 * there[0][1, 1]
    np.testing.assert_allclose(uncertainty.pose_covariance(Pose2D(1.0), match), there[1], atol=1e-12)


def test_heading_uncertainty_makes_the_place_uncertain() -> None:
    C = propagate(np.diag([0.0, 0.0, 0.01]), Pose2D(), Pose2D(2.0, 0.0, 0.0))
    np.testing.assert_allclose(C, [[0, 0, 0], [0, 0.04, 0.02], [0, 0.02, 0.01]], atol=1e-12)


def test_incompatible_parts_are_refused() -> None:
    with pytest.raises(ValidationError, match="force_field goes with points"):
        SlamConfig.model_validate({"mode": "paper", "map": {"method": "surfels"}})


def test_echoes_at_the_end_of_the_reach_are_left_out() -> None:
    """Near the range limit only readings that are too short arrive, so that a wall would be mapped too near."""
    scan = scan_of(ROOM, Pose2D(), noise=0.02)
    facets = facets_of(scan, extract_segments(scan, SlamConfig().lines), 0.2)
    nearer = replace(scan, range_max=4.0, ranges=np.where(scan.ranges <= 4.0, scan.ranges, np.inf))
    cut = facets_of(nearer, extract_segments(nearer, SlamConfig().lines), 0.2)
    assert 0 < len(cut) < len(facets)
    assert np.hypot(cut[:, X], cut[:, Y]).max() < 4.0 - 0.02


def test_a_lost_robot_does_not_change_the_map() -> None:
    """The settings make every matched scan count as lost, so the map stays that of the first scan."""
    slam = LineSlam(
        SlamConfig.model_validate({"loops": "never", "matching": {"lost_below": 1.0, "lost_after": 1}}), Pose2D()
    )
    path = [Pose2D(0.1 * k) for k in range(10)]
    found = [slam.update(scan_of(ROOM, pose, 0.01, k, 0.1 * k), Odometry(0.1 * k, pose)) for k, pose in enumerate(path)]
    assert [estimate.lost for estimate in found] == [False] + 9 * [True]
    assert len({estimate.map_points for estimate in found}) == 1
