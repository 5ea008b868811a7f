"""The simulated robot, as seen by the method."""

import hashlib
import subprocess
import sys
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from math import hypot, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from sim.bumpers import Contact, segment_at
from sim.robot import SimRobot
from sim.robot_in_world import _say_what_is_missing
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.scan import LaserScan
from slam.scenario.schema import Scenario

CORRIDOR = {"points": [[-1.0, -1.25], [9.0, -1.25], [9.0, 1.25], [-1.0, 1.25]], "closed": True}


def scenario(**changes: object) -> Scenario:
    settings: dict[str, object] = {
        "name": "test",
        "world": {"walls": [CORRIDOR], "boxes": [{"center": [3.0, 0.9], "size": [0.5, 0.4, 0.6], "yaw": 0.3}]},
        "robot": {"odometry": {"travel_noise": 0.01}},
    }
    return Scenario.model_validate(settings | changes)


def observations(robot: SimRobot, count: int) -> Iterator[Observation]:
    for index in range(count):
        robot.drive(Twist2D(0.4, 0.5 * np.sin(0.3 * index)))
        observation = robot.observe()
        assert observation is not None
        yield observation


def observations_straight(robot: SimRobot, count: int) -> Iterator[Observation]:
    for _ in range(count):
        robot.drive(Twist2D(0.5, 0.0))
        observation = robot.observe()
        assert observation is not None
        yield observation


def beam_times(scan: LaserScan) -> np.ndarray:
    """Seconds from the first beam to each that came back."""
    return scan.time_increment * np.flatnonzero(scan.echoes)


def digest(seen: Iterable[Observation]) -> str:
    """Return a hash of the observations."""
    parts = (
        s.scan.ranges.tobytes() + repr((s.odometry, s.T_map_base, s.collided, s.stalled, s.bumpers, s.sonar)).encode()
        for s in seen
    )
    return hashlib.sha256(b"".join(parts)).hexdigest()


def fingerprint(robot: SimRobot) -> str:
    return digest(observations(robot, 20))


def fingerprint_of(seed: int) -> str:
    with SimRobot(scenario(), seed) as robot:
        return fingerprint(robot)


def test_the_same_seed_gives_the_same_observations_bit_by_bit() -> None:
    assert fingerprint_of(5) == fingerprint_of(5)
    assert fingerprint_of(5) != fingerprint_of(6)


def test_the_seed_of_the_scenario_is_the_default() -> None:
    with SimRobot(scenario(seed=5)) as robot:
        assert fingerprint(robot) == fingerprint_of(5)


def test_two_robots_side_by_side_do_not_disturb_each_other() -> None:
    with SimRobot(scenario(), 5) as first, SimRobot(scenario(), 6) as second:
        pairs = zip(observations(first, 20), observations(second, 20), strict=True)
        assert digest(seen for seen, _ in pairs) == fingerprint_of(5)


def test_a_fresh_process_gives_the_same_observations() -> None:
    code = "import test_sim_robot; print(test_sim_robot.fingerprint_of(5))"
    tests = Path(__file__).parent
    run = subprocess.run([sys.executable, "-c", code], cwd=tests, capture_output=True, text=True, check=True)
    assert run.stdout.split() == [fingerprint_of(5)]
    assert bool(run.stderr) == (find_spec("pybullet") is None)  # a warning that PyBullet is missing


def test_lidar_and_odometry_have_noise_of_their_own() -> None:
    with SimRobot(scenario(), 5) as noisy, SimRobot(scenario(lidar={"dropout": 0.5, "model": "table1"}), 5) as other:
        pairs = list(zip(observations(noisy, 10), observations(other, 10), strict=True))
    assert all(a.odometry == b.odometry for a, b in pairs)
    assert all(len(a.scan.ranges) != len(b.scan.ranges) for a, b in pairs)


@pytest.mark.parametrize("rolling", [True, False])
def test_an_observation_has_one_time(rolling: bool) -> None:
    room = scenario(robot={"start": {"x": 1.0, "y": 0.2, "theta": 0.3}}, lidar={"noise": "none", "rolling": rolling})
    with SimRobot(room) as robot:
        robot.drive(Twist2D(0.4, 0.0))
        seen = [robot.observe() for _ in range(20)]
    assert [s.scan.stamp for s in seen] == pytest.approx(0.1 * np.arange(1, 21) - (1.0 / 15.0 if rolling else 0.0))
    assert all(s.odometry.stamp == s.scan.stamp for s in seen)
    for s in seen:
        true = Pose2D(1.0, 0.2, 0.3) @ s.odometry.T_odom_base
        assert true.distance(s.T_map_base) < 1e-3
        points = (s.T_map_base @ robot.T_base_laser).transform(s.scan.points())
        points += (
            s.odometry.twist.linear * beam_times(s.scan)[:, None] * s.T_map_base.rotation[:, 0]
        )  # it drives straight
        on_left_wall = abs(points[:, 1] - 1.2) < 0.01
        assert on_left_wall.sum() > 50
        assert abs(points[on_left_wall, 1] - 1.2).max() < 1e-3


def test_the_lidar_sits_where_it_is_mounted() -> None:
    wall = {"walls": [{"points": [[3.05, -5.0], [3.05, 5.0]]}]}
    mount = {"x": 0.1, "y": -0.2, "theta": pi / 2}
    with SimRobot(scenario(world=wall, lidar={"noise": "none", "mount": mount})) as robot:
        seen = robot.observe()
    assert seen.scan.ranges[384 - 44 - 256] == pytest.approx(2.9, abs=1e-3)


def test_the_duration_sets_the_number_of_scans() -> None:
    with SimRobot(scenario(duration=0.55)) as robot:
        seen = [robot.observe() for _ in range(7)]
    assert [s is None for s in seen] == [False] * 5 + [True] * 2


def test_a_wall_contact_is_reported_while_it_lasts() -> None:
    with SimRobot(scenario(world={"walls": [{"points": [[1.5, -2.0], [1.5, 2.0]]}]})) as robot:
        seen = list(observations_straight(robot, 60))
        first = next(i for i, s in enumerate(seen) if s.collided)
        assert seen[first - 1].T_map_base.x < 1.45 - 0.21 < seen[first].T_map_base.x + 0.01
        assert all(s.collided for s in seen[first:])
        assert seen[-1].T_map_base.x == pytest.approx(1.45 - 0.21, abs=5e-3)
        for _ in range(20):
            robot.drive(Twist2D(-0.5, 0.0))
            last = robot.observe()
        assert not last.collided


def test_a_short_touch_between_two_scans_is_reported() -> None:
    agile = {"limits": {"acceleration": 5.0, "deceleration": 50.0}}
    with SimRobot(
        scenario(world={"walls": [{"points": [[1.0, -2.0], [1.0, 2.0]]}]}, robot=agile, lidar={"rolling": False})
    ) as robot:
        robot.drive(Twist2D(0.5, 0.0))
        while not (seen := robot.observe()).collided:
            pass
        robot.drive(Twist2D(-0.5, 0.0))
        after = robot.observe()
    assert after.T_map_base.x < seen.T_map_base.x - 0.005
    assert after.collided


def test_the_robot_passes_a_wide_enough_gap() -> None:
    sides = [{"points": [[0.0, side], [2.0, side]]} for side in (-0.25, 0.25)]  # 0.40 m for a body 0.381 m wide
    with SimRobot(scenario(world={"walls": sides})) as robot:
        seen = list(observations_straight(robot, 40))
    assert not any(s.collided for s in seen)
    assert seen[-1].T_map_base.x > 1.0


def test_drive_returns_what_is_applied() -> None:
    with SimRobot(scenario(robot={"limits": {"linear": 0.6}})) as robot:
        assert robot.drive(Twist2D(0.4, 0.1)) == Twist2D(0.4, 0.1)
        assert robot.drive(Twist2D(4.0, 0.1)) == Twist2D(0.6, 0.1)
        with pytest.raises(RobotError, match="finite"):
            robot.drive(Twist2D(float("nan"), 0.0))


CROWD = {
    "people": [{"waypoints": [[2.0, -0.6], [2.0, 0.6]]}, {"waypoints": [[1.4, 0.1]]}],
    "robot": {"odometry": {"travel_noise": 0.01, "encoder_noise": 3.0}, "traction": {"slip": 0.02}, "sonar": True},
}


@pytest.mark.parametrize(
    "lidar", [{}, {"caster": "exact", "noise": "realistic"}, {"rolling": False, "noise": "datasheet"}]
)
def test_a_restarted_robot_equals_a_new_one(lidar: str) -> None:
    crowd = scenario(lidar=lidar, **CROWD)
    with SimRobot(crowd, 3) as robot, SimRobot(crowd, 8) as fresh:
        first = list(observations(robot, 40))
        assert any(s.collided for s in first)
        robot.restart(8)
        assert digest(observations(robot, 40)) == digest(observations(fresh, 40))
        robot.restart(3)
        assert digest(observations(robot, 40)) == digest(first)


def test_a_wall_ahead_presses_the_bumper_and_stalls() -> None:
    with SimRobot(scenario(world={"walls": [{"points": [[1.0, -2.0], [1.0, 2.0]]}]})) as robot:
        seen = list(observations_straight(robot, 60))
    assert not seen[0].collided
    assert seen[0].bumpers == (False,) * 10
    assert not any(s.stalled for s in seen if not s.collided)
    assert seen[-1].collided
    assert seen[-1].stalled
    assert any(seen[-1].bumpers[:5])
    assert not any(seen[-1].bumpers[5:])


@pytest.mark.parametrize(
    ("contact", "segment"),
    [
        ((1.3, 0.0), 2),
        ((1.3, 0.15), 1),
        ((1.3, -0.15), 3),
        ((1.1, 0.2), 0),
        ((0.7, 0.0), 7),
        ((0.7, 0.2), 6),
        ((1.0, 0.2), None),
    ],
)
def test_a_contact_presses_the_segment_in_its_direction(contact: Any, segment: int) -> None:
    x, y = contact
    assert segment_at(Contact(x, y, pushable=False), (1.0, 0.0, 0.0)) == segment
    turned = Contact(1.0 - y, x - 1.0, pushable=False)  # the robot at (1, 0) looks along +y
    assert segment_at(turned, (1.0, 0.0, pi / 2)) == segment


def test_the_sonar_ring_sees_walls_and_people_to_five_metres() -> None:
    room = {"walls": [{"points": [[4.05, -9.0], [4.05, 9.0]]}, {"points": [[-1.0, 3.05], [9.0, 3.05]]}]}
    person = {"waypoints": [[0.8, -0.7]]}
    with SimRobot(scenario(world=room, people=[person], robot={"sonar": True})) as robot:
        left, *_, ahead_left, ahead_right, _, near, right = robot.observe().sonar
    assert left == pytest.approx((3.0 - 0.136), abs=2e-3)
    assert (ahead_left, ahead_right) == pytest.approx((4.0 - 0.166,) * 2, abs=0.01)
    assert 0.5 < near < 1.0
    assert right == np.inf


def test_beams_start_at_the_sensor_pose_of_their_time() -> None:
    box = {"walls": [CORRIDOR]}
    skews = []
    for rolling in (True, False):
        lidar = {"rolling": rolling, "noise": "none"}
        with SimRobot(scenario(world=box, robot={"limits": {"angular_acceleration": 20.0}}, lidar=lidar)) as robot:
            for _ in range(12):
                robot.drive(Twist2D(0.0, 1.5))
                seen = robot.observe()
        points = (seen.T_map_base @ robot.T_base_laser).transform(seen.scan.points())
        walls = np.minimum.reduce([abs(points[:, 1] - 1.2), abs(points[:, 1] + 1.2), abs(points[:, 0] + 0.95)])
        skews.append(np.mean(walls))
    assert skews[1] < 1e-3
    assert skews[0] > 0.02


def test_a_person_waits_for_the_robot_to_pass() -> None:
    person = {"waypoints": [[3.0, 0.0], [0.0, 0.0]], "keep": 0.8}
    with SimRobot(scenario(world={"walls": [CORRIDOR]}, people=[person])) as robot:
        for _ in range(60):
            seen = robot.observe()
            assert not seen.collided
        assert np.array(seen.people) == pytest.approx(np.array([[0.8, 0.0]]), abs=0.02)
        for _ in range(30):
            robot.drive(Twist2D(-0.5, 0.0))
            seen = robot.observe()
        assert seen.people[0][0] < 0.5


@pytest.mark.parametrize("way", [[[2.0, 0.0], [-0.9, 0.0]], [[0.0, 1.1], [0.0, -1.1]], [[0.8, 0.8], [-0.8, -0.8]]])
def test_nobody_walks_into_a_standing_robot(way: Any) -> None:
    with SimRobot(scenario(world={"walls": [CORRIDOR]}, people=[{"waypoints": way, "speed": 1.5}])) as robot:
        assert not any(robot.observe().collided for _ in range(30))


def test_a_heedless_person_pushes_the_robot_gently() -> None:
    careless = {"waypoints": [[0.0, 1.1], [0.0, -1.1]], "keep": 0.0}
    with SimRobot(scenario(world={"walls": [CORRIDOR]}, people=[careless])) as robot:
        seen = [robot.observe() for _ in range(30)]
    assert any(s.collided for s in seen)
    assert max(hypot(s.T_map_base.x, s.T_map_base.y) for s in seen) < 0.2


def test_running_into_a_person_is_a_collision() -> None:
    person = {"waypoints": [[1.0, 0.0]]}
    with SimRobot(scenario(world={"walls": [CORRIDOR]}, people=[person])) as robot:
        seen = list(observations_straight(robot, 60))
    first = next(i for i, s in enumerate(seen) if s.collided)
    assert seen[first].T_map_base.x == pytest.approx(1.0 - 0.06 - 0.21, abs=0.03)
    assert seen[-1].T_map_base.x < 0.85


def test_a_closed_robot_reports_it() -> None:
    with SimRobot(scenario()) as robot:
        robot.observe()
    robot.close()
    with pytest.raises(RobotError, match="closed"):
        robot.observe()
    with pytest.raises(RobotError, match="closed"):
        robot.drive(Twist2D())


def test_physics_control_and_scans_divide_one_another() -> None:
    with pytest.raises(ValidationError, match=r"physics\.rate = 245 is not a multiple of robot\.control_rate = 60"):
        scenario(physics={"rate": 245})
    with pytest.raises(ValidationError, match=r"robot\.control_rate = 75 gives 7\.5 control steps"):
        scenario(physics={"rate": 150}, robot={"control_rate": 75})
    with SimRobot(scenario(physics={"rate": 100}, robot={"control_rate": 50})) as robot:
        stamps = [robot.observe().scan.stamp for _ in range(2)]
    assert stamps == pytest.approx([0.02, 0.12])  # the beams take 66.6 ms, which are 4 control steps of 20 ms


@pytest.mark.parametrize(("physics", "warned"), [({"rate": 240}, True), ({"engine": "plan"}, False)])
def test_a_missing_pybullet_is_named_if_no_engine_is_chosen(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, physics: dict[str, object], warned: bool
) -> None:
    monkeypatch.setattr("slam.scenario.clock.find_spec", lambda _: None)
    _say_what_is_missing.cache_clear()
    with SimRobot(scenario(physics=physics)):
        assert ("PyBullet is not installed" in caplog.text) == warned
    _say_what_is_missing.cache_clear()
