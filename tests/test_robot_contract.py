"""One suite that every back end of the ``Robot`` protocol passes."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from hardware.emulator.emulator import Emulator
from slam.errors import HopslamError, RobotError, ScenarioError
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.robot import Robot
from slam.run.backends import BACKENDS, make_robot
from slam.scenario.file import load_scenario
from tests.rooms import room_plant
from tests.topic_node import SimulatedNode

SCANS = 12


def sim_robot(log: Path, devices: ExitStack) -> Robot:
    return make_robot("sim", load_scenario("paper_simulation", [f"duration={0.1 * SCANS}"]), seed=1)


def plan_robot(log: Path, devices: ExitStack) -> Robot:
    settings = [f"duration={0.1 * SCANS}", "physics.engine=plan"]
    return make_robot("sim", load_scenario("paper_simulation", settings), seed=1)


def replay_robot(log: Path, devices: ExitStack) -> Robot:
    return make_robot("replay", log)


def hardware_robot(log: Path, devices: ExitStack) -> Robot:
    """The robot of emulated devices at two pseudo-terminals."""
    emulator = devices.enter_context(Emulator(room_plant((-2.0, 3.5), (-2.0, 2.0), 0.16), paced=False))
    settings = [*emulator.port_settings, f"duration={0.1 * SCANS}"]
    return make_robot("hardware", load_scenario("corridor", settings), yes=True)


def ros_robot(log: Path, devices: ExitStack) -> Robot:
    """The robot on the topics of a simulated node."""
    settings = ["physics.engine=plan", "lidar.noise=none"]
    node = devices.enter_context(SimulatedNode(load_scenario("corridor", settings)))
    return make_robot("ros", load_scenario("corridor", [*settings, f"duration={0.1 * SCANS}"]), bus=node.bus)


MAKERS: dict[str, Callable[[Path, ExitStack], Robot]] = {
    "sim": sim_robot,
    "sim, plan": plan_robot,
    "replay": replay_robot,
    "hardware": hardware_robot,
    "ros": ros_robot,
}


@pytest.fixture(params=sorted(MAKERS))
def make(request: pytest.FixtureRequest, small_log: Path) -> Iterator[Callable[[], Robot]]:
    with ExitStack() as devices:
        yield lambda: MAKERS[request.param](small_log, devices)


def test_every_back_end_is_tested_here() -> None:
    assert {name.split(",")[0] for name in MAKERS} == set(BACKENDS)


def test_scans_come_in_order_and_end(make: Callable[[], Robot]) -> None:
    stamps = []
    with make() as robot:
        assert isinstance(robot.T_base_laser, Pose2D)
        while (observation := robot.observe()) is not None:
            stamps.append(observation.scan.stamp)
            robot.drive(Twist2D(0.2, 0.0))
        assert robot.observe() is None
    assert len(stamps) == SCANS
    assert (np.diff(stamps) > 0).all()


def test_a_scan_is_complete(make: Callable[[], Robot]) -> None:
    with make() as robot:
        observation = robot.observe()
        assert observation is not None
        scan = observation.scan
        assert scan.ranges.dtype == np.float64
        assert scan.ranges.ndim == 1
        echoes = scan.ranges[scan.echoes]
        assert len(echoes) > 50
        assert scan.range_min <= echoes.min() <= echoes.max() <= scan.range_max
        assert scan.scan_time > 0
        assert observation.odometry.stamp == pytest.approx(scan.stamp, abs=scan.scan_time)


def test_odometry_starts_at_the_origin_and_moves(make: Callable[[], Robot]) -> None:
    with make() as robot:
        first = robot.observe()
        assert first is not None
        assert first.odometry.T_odom_base.distance(Pose2D()) < 1e-3
        for _ in range(SCANS - 1):
            robot.drive(Twist2D(0.2, 0.0))
            last = robot.observe()
        assert last is not None
        assert 0.02 < last.odometry.T_odom_base.x < 1.0


def test_drive_returns_the_applied_command(make: Callable[[], Robot]) -> None:
    with make() as robot:
        robot.observe()
        applied = robot.drive(Twist2D(50.0, 0.0))
        assert 0.0 < applied.linear <= 1.3


@pytest.mark.parametrize("make", ["replay", "sim", "sim, plan"], indirect=True)  # in real time no two runs are equal
def test_the_same_robot_twice_is_the_same(make: Callable[[], Robot]) -> None:
    runs = []
    for _ in range(2):
        with make() as robot:
            seen = []
            while (observation := robot.observe()) is not None:
                seen.append(observation)
                robot.drive(Twist2D(0.3, 0.1))
            runs.append(seen)
    assert runs[0] == runs[1]


def test_a_closed_robot_refuses_all_calls(make: Callable[[], Robot]) -> None:
    with make() as robot:
        robot.observe()
    with pytest.raises(RobotError):
        robot.observe()
    with pytest.raises(RobotError):
        robot.drive(Twist2D())


def test_an_exception_closes_the_robot(make: Callable[[], Robot]) -> None:
    robot = make()
    with pytest.raises(ZeroDivisionError), robot:
        raise ZeroDivisionError
    with pytest.raises(RobotError):
        robot.observe()


def test_an_unknown_back_end_names_the_known_ones() -> None:
    with pytest.raises(ScenarioError, match="did you mean replay"):
        make_robot("replai")
    with pytest.raises(HopslamError, match="choose one of sim, replay, hardware, ros"):
        make_robot("Roomba")
