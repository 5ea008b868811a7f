"""The whole method on simulated scans."""

import numpy as np
import pytest
from pydantic import ValidationError

from sim.robot import SimRobot
from slam.config import PointMapConfig, SlamConfig
from slam.line_slam import Estimate, LineSlam
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.scan import LaserScan
from slam.scenario.file import load_scenario

PAPER = load_scenario("paper_simulation", ["robot.odometry.travel_noise=0.01"])
ALL_POINTS = PAPER.slam.model_copy(update={"map": PointMapConfig(draw=1.0)})
"""All points are kept: the random draw would change if a point at the range limit came or went."""


@pytest.fixture(scope="module")
def drive() -> list[Observation]:
    """Forty scans up the passage of the paper's simulation."""
    with SimRobot(PAPER, seed=2) as robot:
        seen = []
        for _ in range(40):
            observation = robot.observe()
            assert observation is not None
            seen.append(observation)
            robot.drive(Twist2D(0.4, 0.0))
    return seen


def estimates(drive: list[Observation], config: SlamConfig, start: Pose2D, seed: int = 0) -> list[Estimate]:
    slam = LineSlam(config, Pose2D(), start, seed)
    return [slam.update(seen.scan, seen.odometry) for seen in drive]


def test_line_slam_follows_the_truth(drive: list[Observation]) -> None:
    for seen, estimate in zip(drive, estimates(drive, PAPER.slam, PAPER.robot.start.pose), strict=True):
        assert seen.T_map_base is not None
        error = seen.T_map_base.between(estimate.T_map_base)
        assert error.distance(Pose2D()) < 0.05
        assert abs(error.theta) < np.radians(0.5)


def test_the_first_scan_is_the_anchor(drive: list[Observation]) -> None:
    """Section 4: at the first step the estimate is the truth."""
    first = estimates(drive[:1], PAPER.slam, Pose2D(1.0, 2.0, 0.3))[0]
    assert first.T_map_base.distance(Pose2D(1.0, 2.0, 0.3)) < 1e-12
    assert first.mapped
    assert first.match.iterations == 0


def test_the_same_scans_and_seed_give_the_same_bits(drive: list[Observation]) -> None:
    once, again = (estimates(drive, PAPER.slam, Pose2D()) for _ in range(2))
    assert [e.T_map_base for e in once] == [e.T_map_base for e in again]
    assert [e.T_map_base for e in once] != [e.T_map_base for e in estimates(drive, PAPER.slam, Pose2D(), seed=1)]


def test_the_map_frame_can_be_any_frame(drive: list[Observation]) -> None:
    """Starting elsewhere moves the whole trajectory rigidly."""
    start = Pose2D(-3.0, 7.0, 2.0)
    for here, there in zip(estimates(drive, ALL_POINTS, Pose2D()), estimates(drive, ALL_POINTS, start), strict=True):
        assert there.T_map_base.distance(start @ here.T_map_base) < 5e-4


def test_svd_and_prefix_sums_give_the_same_run(drive: list[Observation]) -> None:
    by_svd = ALL_POINTS.model_copy(update={"lines": ALL_POINTS.lines.model_copy(update={"kernel": "svd"})})
    for fast, plain in zip(estimates(drive, ALL_POINTS, Pose2D()), estimates(drive, by_svd, Pose2D()), strict=True):
        assert fast.T_map_base.distance(plain.T_map_base) < 5e-4


def test_between_updates_the_pose_follows_odometry(drive: list[Observation]) -> None:
    config = SlamConfig(mode="paper", matching=PAPER.slam.matching, update_distance=0.2)
    run = estimates(drive, config, Pose2D())
    mapped = [k for k, estimate in enumerate(run) if estimate.mapped]
    assert 3 <= len(mapped) <= 8
    for k in range(1, len(run)):
        if not run[k].mapped:
            wheels = drive[k - 1].odometry.T_odom_base.between(drive[k].odometry.T_odom_base)
            assert run[k].T_map_base.distance(run[k - 1].T_map_base @ wheels) < 1e-12


def test_without_odometry_wheel_motion_is_ignored(drive: list[Observation]) -> None:
    config = ALL_POINTS.model_copy(update={"odometry": False})
    slam = LineSlam(config, Pose2D(), Pose2D())
    for k, (seen, plain) in enumerate(zip(drive, estimates(drive, config, Pose2D()), strict=True)):
        nonsense = Odometry(seen.odometry.stamp, Pose2D(3.0 * k, -5.0 * k, 0.7 * k))
        assert slam.update(seen.scan, nonsense).T_map_base == plain.T_map_base


def blind(scan: LaserScan) -> LaserScan:
    """The scan, had nothing come back."""
    return LaserScan(
        scan.stamp, scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, np.full(128, np.inf)
    )


@pytest.mark.parametrize("turn", [0.07, -0.07])
def test_turning_triggers_an_update(drive: list[Observation], turn: float) -> None:
    """Three times 0.07 rad are more than 0.2, whichever way; nothing is seen that could correct the heading."""
    slam = LineSlam(SlamConfig(mode="paper", update_distance=10.0, update_angle=0.2), Pose2D())
    run = [slam.update(blind(drive[0].scan), Odometry(0.1 * k, Pose2D(0.0, 0.0, turn * k))) for k in range(10)]
    assert [k for k, estimate in enumerate(run) if estimate.mapped] == [0, 3, 6, 9]


def test_an_update_reports_its_work(drive: list[Observation]) -> None:
    for estimate in estimates(drive, SlamConfig(mode="paper", update_distance=0.2), Pose2D()):
        if estimate.mapped:
            assert 0.0 < estimate.extraction_time < estimate.total_time
        else:
            assert 0.0 == estimate.extraction_time < estimate.total_time


def test_a_scan_without_an_echo_keeps_the_prior(drive: list[Observation]) -> None:
    slam = LineSlam(SlamConfig(mode="paper", matching=PAPER.slam.matching), Pose2D())
    for seen in drive[:3]:
        slam.update(seen.scan, seen.odometry)
    before = slam.T_map_base
    estimate = slam.update(blind(drive[3].scan), drive[3].odometry)
    wheels = drive[2].odometry.T_odom_base.between(drive[3].odometry.T_odom_base)
    assert estimate.T_map_base.distance(before @ wheels) < 1e-12


def test_the_mount_of_the_sensor_is_used(drive: list[Observation]) -> None:
    """The same scans seen as from a sensor 0.3 m ahead of the base: the base follows, rigidly."""
    mount = Pose2D(0.3, 0.0, 0.0)
    slam = LineSlam(ALL_POINTS, mount, Pose2D())
    plain = estimates(drive, ALL_POINTS, mount)
    for seen, estimate in zip(drive, plain, strict=True):
        base = slam.update(seen.scan, seen.odometry).T_map_base
        assert (base @ mount).distance(estimate.T_map_base) < 5e-4


def test_steps_without_odometry_are_refused() -> None:
    with pytest.raises(ValidationError, match="update_distance needs odometry"):
        SlamConfig(odometry=False, update_distance=0.1)
