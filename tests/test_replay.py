"""A log as a robot: scan after scan, with the recorded velocity whatever the command."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.errors import LogError, RobotError
from slam.files.logs import Log, read_log
from slam.lidars import Lidar
from slam.odometry import Twist2D, wheel_motion
from slam.pose import FloatArray, Pose2D
from slam.run.replay_robot import ReplayRobot

DATA = Path(__file__).parents[1] / "../shared/data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded logs in {DATA}")
TRACK = 0.33
travels = st.floats(-0.4, 0.4)


def log_of(stamps: list[float], poses: list[Pose2D]) -> Log:
    ranges: FloatArray = np.arange(3.0 * len(stamps)).reshape(-1, 3)
    return Log(
        lidar=Lidar(-0.5, 0.5, 3, 0.1, 9.0, 0.1),
        T_base_laser=Pose2D(0.2),
        stamps=np.array(stamps),
        ranges=ranges,
        T_odom_base=np.array([(pose.x, pose.y, pose.theta) for pose in poses]),
        time_increment=0.001,
        skipped={},
        ignored={},
        report="by hand",
    )


THREE = log_of([10.0, 10.5, 11.0], [Pose2D(), Pose2D(1.0), Pose2D(1.0, 0.0, 0.25)])


def test_scans_come_in_order_and_end() -> None:
    with ReplayRobot(THREE) as robot:
        assert len(robot) == 3
        assert robot.log.lidar == THREE.lidar
        assert robot.T_base_laser == Pose2D(0.2)
        seen = [robot.observe() for _ in range(5)]
    assert seen[3:] == [None, None]
    for index, observation in enumerate(seen[:3]):
        assert observation is not None
        assert observation.T_map_base is None
        assert observation.scan.stamp == observation.odometry.stamp == THREE.stamps[index]
        assert observation.odometry.T_odom_base == THREE.pose(index)
        assert observation.scan.lidar == robot.log.lidar
        np.testing.assert_array_equal(observation.scan.ranges, THREE.ranges[index])


def test_a_replay_ignores_the_command() -> None:
    with ReplayRobot(THREE) as robot:
        driven = [robot.drive(Twist2D(9.0, 9.0))]
        while robot.observe() is not None:
            driven.append(robot.drive(Twist2D(9.0, 9.0)))
    assert driven == [Twist2D(), Twist2D(2.0, 0.0), Twist2D(0.0, 0.5), Twist2D()]


def test_the_velocity_is_that_between_odometry_poses() -> None:
    assert [THREE.odometry(i).twist for i in range(3)] == [Twist2D(), Twist2D(2.0, 0.0), Twist2D(0.0, 0.5)]


@given(travels, travels, st.floats(0.01, 10.0))
def test_the_velocity_is_that_of_the_wheels(left: float, right: float, seconds: float) -> None:
    start = Pose2D(3.0, -2.0, 3.0)
    twist = log_of([0.0, seconds], [start, start @ wheel_motion(left, right, TRACK)]).twist(0)
    assert twist.linear * seconds == pytest.approx((left + right) / 2, abs=1e-9)
    assert twist.angular * seconds == pytest.approx((right - left) / TRACK, abs=1e-9)


def test_a_closed_replay_refuses_calls() -> None:
    with ReplayRobot(THREE) as robot:
        robot.observe()
    robot.close()
    with pytest.raises(RobotError, match="closed"):
        robot.observe()
    with pytest.raises(RobotError, match="closed"):
        robot.drive(Twist2D())


def test_the_recording_cannot_be_changed() -> None:
    observation = ReplayRobot(THREE).observe()
    assert observation is not None
    with pytest.raises(ValueError, match="read-only"):
        observation.scan.ranges[0] = 1.0


def test_a_path_without_a_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no such file"):
        ReplayRobot(tmp_path / "absent.log")


@needs_data
def test_a_recorded_log_drives_along_its_odometry() -> None:
    log = read_log(DATA / "wean1.log.gz")
    expected = Pose2D()
    with ReplayRobot(log) as robot:
        for index, seconds in enumerate(np.diff(log.stamps).tolist()):
            observation = robot.observe()
            assert observation is not None
            assert observation.scan.stamp == log.stamps[index]
            assert observation.scan.echoes.sum() > 100
            assert observation.odometry.T_odom_base.distance(expected) < 0.02
            twist = robot.drive(Twist2D())
            difference = twist.angular * TRACK / 2
            left, right = (twist.linear - difference) * seconds, (twist.linear + difference) * seconds
            expected = observation.odometry.T_odom_base @ wheel_motion(left, right, TRACK)
        assert robot.observe() is not None
        assert robot.observe() is None
