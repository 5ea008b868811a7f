"""Loops closed during a run: a ring of rooms, and wheels that turn too far."""

import itertools
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.graph.closure import ClosedRun
from slam.graph.loop_closing import STEPPED, Timing
from slam.line_slam import Estimate, LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.scan import LaserScan
from tests.ring import around, ranges_from

Scanner = Callable[..., LaserScan]
BEARINGS = np.arange(-2.0, 2.0, 0.02)


@cache
def drive(laps: float, loops: str, timing: Timing = STEPPED) -> tuple[list[Estimate], ClosedRun | None, LineSlam]:
    """Drive with wheels that turn by two degrees a metre too far."""
    random, path = np.random.default_rng(0), around(laps)
    slam = LineSlam(SlamConfig.model_validate({"loops": loops}), Pose2D(), path[0], timing=timing)
    wheels, estimates = path[0], []
    for k, pose in enumerate(path):
        if k:
            motion = path[k - 1].between(pose)
            wheels = wheels @ Pose2D(
                1.02 * motion.x, motion.y, motion.theta + np.radians(2.0) * motion.distance(Pose2D())
            )
        ranges = ranges_from(pose, BEARINGS) + random.normal(0.0, 0.01, len(BEARINGS))
        ranges[ranges > 4.0] = np.inf
        scan = LaserScan(0.1 * k, float(BEARINGS[0]), 0.02, 0.05, 4.0, ranges)
        estimates.append(slam.update(scan, Odometry(0.1 * k, wheels)))
    return estimates, slam.finish(), slam


def errors(poses: FloatArray, laps: float) -> FloatArray:
    return np.asarray(np.hypot(*(poses - stack_poses(around(laps)))[:, :2].T))


def local_poses(estimates: list[Estimate]) -> FloatArray:
    return stack_poses(estimate.T_local_base for estimate in estimates)


def test_a_ring_is_closed() -> None:
    estimates, closed, _ = drive(2.0, "auto")
    assert closed is not None
    assert (closed.weights > 0.5).sum() >= 2
    final = errors(closed.trajectory(local_poses(estimates)), 2.0)
    assert np.sqrt(np.mean(final**2)) < 0.05
    assert len(closed.map) > 0


def test_the_trajectory_has_every_scan_from_the_true_start() -> None:
    estimates, closed, _ = drive(2.0, "auto")
    assert closed is not None
    trajectory = closed.trajectory(local_poses(estimates))
    assert len(trajectory) == len(estimates)
    np.testing.assert_allclose(trajectory[0], stack_poses(around(2.0))[0], atol=1e-9)


def test_the_same_scans_give_the_same_bits() -> None:
    one, closed, _ = drive(2.0, "auto")
    other, again, _ = drive.__wrapped__(2.0, "auto")
    assert np.array_equal(stack_poses(e.T_map_base for e in one), stack_poses(e.T_map_base for e in other))
    assert closed is not None
    assert again is not None
    assert np.array_equal(closed.nodes, again.nodes)


def test_a_run_in_real_time_is_repeated_bit_by_bit() -> None:
    estimates, _, _ = drive.__wrapped__(2.0, "auto", Timing(real_time=True))
    taken_over = {k: estimate.closure.submap for k, estimate in enumerate(estimates) if estimate.closure is not None}
    again, _, _ = drive.__wrapped__(2.0, "auto", Timing(known=taken_over))
    assert np.array_equal(stack_poses(e.T_map_base for e in estimates), stack_poses(e.T_map_base for e in again))


def test_odometry_does_not_jump_where_the_map_does() -> None:
    """Unless a closure is taken over, T_map_local moves by less than 0.1 m from one scan to the next."""
    estimates, _, slam = drive(2.0, "auto")
    for before, estimate in itertools.pairwise(estimates):
        change = before.T_map_local.between(estimate.T_map_local)
        at_robot = before.T_local_base.inverse() @ change @ before.T_local_base
        assert estimate.closure is not None or at_robot.distance(Pose2D()) < 0.1
    assert slam.T_map_base == slam.T_map_local @ slam.T_local_base


def test_the_map_limits_drift_before_a_loop_is_closed() -> None:
    """Before the first loop closes in the second lap, live poses are nearer to the truth than local ones."""
    estimates, _, _ = drive(2.0, "auto")
    truth = stack_poses(around(2.0))
    half = len(truth) // 2
    live, local = stack_poses(e.T_map_base for e in estimates), local_poses(estimates)
    off = [np.hypot(*(poses - truth)[half:, :2].T) for poses in (live, local)]
    assert off[0].mean() < 0.5 * off[1].mean()


def test_without_loops_no_trajectory_is_closed() -> None:
    estimates, closed, slam = drive(0.5, "never")
    assert closed is None
    assert slam.loops is None
    assert all(estimate.closure is None and estimate.T_map_local == Pose2D() for estimate in estimates)


def test_without_a_scan_there_is_no_run_to_close() -> None:
    slam = LineSlam(SlamConfig(), Pose2D())
    assert slam.loops is not None
    assert slam.loops.finish(Pose2D()) is None
    assert slam.loops.size.keys == 0
    assert slam.loops.T_map_local == Pose2D()


def test_paper_mode_closes_no_loops() -> None:
    assert SlamConfig.model_validate({"mode": "paper"}).loops == "never"


@pytest.mark.parametrize("laps", [0.25])
def test_a_short_run_needs_no_other_process(laps: float) -> None:
    estimates, closed, slam = drive(laps, "auto")
    assert slam.loops is not None
    assert slam.loops._process is None
    assert closed is not None
    assert len(closed.loops) == 0
    assert errors(closed.trajectory(local_poses(estimates)), laps).max() < 0.1


def test_the_covariance_bounds_the_pose_errors() -> None:
    """Nine of ten errors of the closed run lie within three standard deviations."""
    _estimates, closed, _ = drive(2.0, "auto")
    assert closed is not None
    truth = stack_poses(around(2.0))[closed.indices]
    sigmas = np.sqrt(np.trace(closed.covariances[:, :2, :2], axis1=1, axis2=2))[1:]
    off = np.hypot(*(closed.poses - truth)[1:, :2].T)
    assert np.mean(off < 3.0 * sigmas + 0.01) > 0.9
