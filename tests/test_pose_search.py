"""The pose search of a scan: missing odometry, jumping odometry, and scans without a match."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.config import LeastSquaresConfig, SlamConfig
from slam.line_slam import Estimate, LineSlam
from slam.mapping.free_beams import free_beams
from slam.mapping.predicted_view import View, compare_view
from slam.mapping.surfel_map import SurfelMap
from slam.matching.surfel_mapper import SurfelMapper
from slam.motion_model import excess_covariance, motion_covariance, updated_excess
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

Scanner = Callable[..., LaserScan]
PATH = [Pose2D(0.05 * k, 0.3 * np.sin(0.1 * k), 0.05 * k) for k in range(40)]
HALL = np.array([[-1, -1.3], [1.2, -1.0], [1.6, 1.4], [0.3, 2.0], [-1.4, 1.1], [-1, -1.3]], float)


def drive(scan_of: Scanner, rooms: list[FloatArray], path: list[Pose2D], wheels: list[Pose2D]) -> list[Estimate]:
    slam = LineSlam(SlamConfig(loops="never"), Pose2D(), path[0])
    return [
        slam.update(scan_of(room, pose, k), Odometry(0.1 * k, odometry))
        for k, (room, pose, odometry) in enumerate(zip(rooms, path, wheels, strict=True))
    ]


def chained(motions: list[Pose2D]) -> list[Pose2D]:
    poses = [Pose2D()]
    for motion in motions:
        poses.append(poses[-1] @ motion)
    return poses


@pytest.mark.parametrize("turn", [0.9, -1.4])
def test_a_motion_missing_from_odometry_is_found(scan_of: Scanner, room: FloatArray, turn: float) -> None:
    """The wheels miss one jump of half a metre and a turn; otherwise they are right."""
    path = PATH[:20] + [PATH[19] @ Pose2D(0.4, 0.3, turn) @ PATH[19].between(pose) for pose in PATH[20:]]
    wheels = chained([Pose2D() if k == 19 else a.between(b) for k, (a, b) in enumerate(pairwise(path))])
    run = drive(scan_of, [room] * 40, path, wheels)
    assert run[20].match.searched
    for truth, estimate in list(zip(path, run, strict=True))[20:]:
        assert truth.distance(estimate.T_map_base) < 0.03
        assert abs(truth.between(estimate.T_map_base).theta) < np.radians(1.0)
        assert not estimate.odometry_only


def test_a_half_turn_is_rejected(scan_of: Scanner, room: FloatArray) -> None:
    """A new place may look like a known one from the other side; then the pose of the wheels is used."""
    path = [*PATH[:20], PATH[19] @ Pose2D(0.4, 0.3, 3.1)]
    wheels = [*PATH[:20], PATH[19] @ Pose2D(0.4, 0.3, 0.0)]
    found = drive(scan_of, [room] * 21, path, wheels)[-1].T_map_base
    assert abs(wheels[-1].between(found).theta) < 1.0


def test_reset_odometry_does_not_move_the_robot(scan_of: Scanner, room: FloatArray) -> None:
    wheels = [Pose2D(30.0, -20.0, 1.0) @ PATH[0].between(pose) for pose in PATH[:20]]
    wheels += [PATH[20].between(pose) for pose in PATH[20:]]
    run = drive(scan_of, [room] * 40, PATH, wheels)
    for truth, estimate in zip(PATH, run, strict=True):
        assert truth.distance(estimate.T_map_base) < 0.03


def test_a_scan_without_a_match_is_not_mapped(scan_of: Scanner, room: FloatArray) -> None:
    """Ten scans in the middle of the drive show another building."""
    rooms = [HALL if 20 <= k < 30 else room for k in range(40)]
    run = drive(scan_of, rooms, PATH, PATH)
    assert all(estimate.odometry_only for estimate in run[20:30])
    assert run[29].map_points <= run[19].map_points
    for truth, estimate in zip(PATH, run, strict=True):
        assert truth.distance(estimate.T_map_base) < 0.05
    assert not run[-1].odometry_only


@pytest.fixture(scope="module")
def mapped(scan_of: Scanner, room: FloatArray) -> SurfelMap:
    slam = LineSlam(SlamConfig(), Pose2D(), PATH[0])
    for k, pose in enumerate(PATH):
        slam.update(scan_of(room, pose, k), Odometry(0.1 * k, pose))
    assert isinstance(slam.mapper, SurfelMapper)
    return slam.mapper.map


def view(surfel_map: SurfelMap, scan: LaserScan, pose: Pose2D) -> View:
    return compare_view(surfel_map.grid, free_beams(scan, 4.0), scan.echoes, pose.as_array(), 8.0)


@given(st.floats(0.0, 1.9), st.floats(-0.3, 0.3), st.floats(-1.0, 2.5))
def test_the_predicted_view_is_the_scan(
    mapped: SurfelMap, scan_of: Scanner, room: FloatArray, x: float, y: float, theta: float
) -> None:
    pose = Pose2D(x, y, theta)
    there = view(mapped, scan_of(room, pose, 1), pose)
    assert there.agreeing > 0.2
    assert there.supported > 0.9
    elsewhere = view(mapped, scan_of(HALL, Pose2D(), 1), pose)
    assert elsewhere.supported < there.supported


def test_an_empty_prediction_rejects_nothing(scan_of: Scanner, room: FloatArray) -> None:
    nothing = view(SurfelMap(SlamConfig().map), scan_of(room, Pose2D(), 1), Pose2D())
    assert nothing == View(0.0, 0.0, 0.0)
    assert nothing.supported == 1.0


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_the_excess_is_bounded_and_beyond_the_model(x: float, y: float, turn: float) -> None:
    config, correction = LeastSquaresConfig(), np.array([x, y, turn])
    small = motion_covariance(Pose2D(), 0.0, config.motion)
    excess = np.zeros(2)
    for _ in range(50):
        excess = updated_excess(excess, correction, small, config)
    most = np.array([config.search.window, config.search.window_angle]) / 3.0
    assert (excess >= 0.0).all()
    assert (excess <= most**2).all()
    assert (updated_excess(np.zeros(2), correction, np.diag(correction**2 + 1e-9) + small, config) == 0.0).all()
    assert np.array_equal(excess_covariance(excess), np.diag([excess[0], excess[0], excess[1]]))
