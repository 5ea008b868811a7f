"""The kinematic robot: its outline, its motors and its random numbers, and PyBullet's robot beside it."""

import subprocess
import sys
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from shapely import LineString, box, unary_union
from shapely.affinity import rotate, translate

from sim.plan.footprint import RADIUS, deepest_overlap
from sim.plan.motors import INERTIA, MASS, MOMENT, rims_after
from sim.random_stream import GOLDEN, fill_normal, fill_uniform, mixed
from sim.robot import SimRobot
from sim.robot_in_world import robot_in_world
from sim.wall_plan import cell_near, wall_plan
from sim.wheels import TRACK, WHEEL_RADIUS
from slam.odometry import Twist2D
from slam.robot import Observation
from slam.scenario.schema import Scenario

OUTLINE = unary_union([box(-0.245, -0.1905, 0.21, 0.1905), box(-0.30, -0.15, -0.245, 0.15)])
"""Outline of the robot in p3dx.urdf."""
NOBODY = np.empty((0, 2)), np.empty(0)
HALL = {"walls": [{"points": [[-50, -50], [50, -50], [50, 50], [-50, 50]], "closed": True}]}
WALL_AHEAD = {"walls": [{"points": [[1.0, -2.0], [1.0, 2.0]]}]}
ONE = st.floats(-0.5, 0.5)


def scenario(engine: str, **changes: object) -> Scenario:
    given = {"name": "test", "world": HALL, "lidar": {"noise": "none", "caster": "exact"}} | changes
    return Scenario.model_validate(given | {"physics": {"engine": engine}, "duration": 1e4})


@settings(max_examples=200)
@given(ONE, ONE, ONE, ONE, st.floats(-pi, pi))
def test_the_outline_hits_a_wall_where_its_polygon_does(
    x: float, y: float, to_x: float, to_y: float, theta: float
) -> None:
    plan = wall_plan([[np.array([[x, y], [to_x, to_y]])]], RADIUS)
    found = deepest_overlap(0.1, -0.2, theta, plan, cell_near(plan, 0, 0.1, -0.2, 0.0), *NOBODY)
    outline = translate(rotate(OUTLINE, theta, (0.0, 0.0), use_radians=True), 0.1, -0.2)
    apart = outline.distance(LineString([(x, y), (to_x, to_y)]))
    if found.depth > 1e-9:
        assert apart == 0.0
    elif found.depth < -1e-9:
        assert apart > 0.0
        assert -found.depth <= apart + 1e-9 or found.depth == -np.inf


@given(ONE, ONE, st.floats(0.01, 0.2))
def test_the_outline_hits_a_leg_where_its_polygon_does(x: float, y: float, radius: float) -> None:
    plan = wall_plan([[]], RADIUS)
    found = deepest_overlap(0.0, 0.0, 0.0, plan, 0, np.array([[x, y]]), np.array([radius]))
    apart = OUTLINE.distance(LineString([(x, y), (x, y)]).centroid)
    assert (found.depth > 1e-9) <= (apart < radius)
    assert (found.depth < -1e-9) <= (apart > radius)


@given(*[st.floats(-1.2, 1.2)] * 4)
def test_motors_accelerate_by_newton_within_their_torque(
    left: float, right: float, left_target: float, right_target: float
) -> None:
    force, seconds = 12.3, 1.0 / 240.0
    after = rims_after(left, right, left_target, right_target, seconds, force, 0.0)
    v, omega = (left + right) / 2.0, (right - left) / TRACK
    a = ((after[0] + after[1]) / 2.0 - v) / seconds
    alpha = ((after[1] - after[0]) / TRACK - omega) / seconds
    both = MASS * a + MOMENT * omega**2
    moment = INERTIA * alpha - MOMENT * v * omega
    wheel = 0.00475 / WHEEL_RADIUS**2
    pushes = (
        both / 2.0 - moment / TRACK + wheel * (after[0] - left) / seconds,
        both / 2.0 + moment / TRACK + wheel * (after[1] - right) / seconds,
    )
    for push, reached, target in zip(pushes, after, (left_target, right_target), strict=True):
        assert abs(push) <= force + 1e-6
        assert reached == pytest.approx(target) or abs(push) == pytest.approx(force)


def test_the_stream_is_splitmix64() -> None:
    """The numbers of the authors' own program for the seed 1234567."""
    seed = np.uint64(1234567)
    with np.errstate(over="ignore"):
        found = [int(mixed(seed + GOLDEN * np.uint64(k))) for k in (1, 2, 3)]
    assert found == [6457827717110365317, 3203168211198807973, 9817491932198370423]


def test_normal_and_uniform_numbers_are_so_distributed() -> None:
    numbers, even = np.empty(200_000), np.empty(100_000)
    stream = fill_normal(np.uint64(3), numbers)
    fill_uniform(np.uint64(stream), even)
    assert stats.kstest(numbers, "norm").pvalue > 1e-3
    assert stats.kstest(even, "uniform").pvalue > 1e-3
    assert abs(np.mean(numbers[1:] * numbers[:-1])) < 0.01
    assert (abs(numbers) > 3.6542).mean() == pytest.approx(2.58e-4, rel=0.5)  # the tail, which is drawn by other code


ERRORS = {"odometry": {"left_radius": 0.099, "track": 0.34}, "traction": {"slip": 0.05, "effective_track": 0.357}}


@pytest.mark.parametrize("robot", [{}, ERRORS], ids=["exact", "errors"])
def test_both_engines_drive_the_same_way(robot: Any) -> None:
    """The commands of a minute reach the limits, so that a motor lacks the torque for its ramp in fast curves."""
    rng = np.random.default_rng(4)
    scenarios = [scenario(engine, robot=robot) for engine in ("bullet", "plan")]
    one, other = bodies = [robot_in_world(made, made.robot, made.clock.rate) for made in scenarios]
    for body in bodies:
        body.restart(0)
    for k in range(600):
        if k % 7 == 0:
            command = Twist2D(rng.uniform(-0.3, 1.2), rng.uniform(-1.5, 1.5))
        assert one.command(command) == other.command(command)
        for body in bodies:
            body.advance(6)
        assert one.pose.distance(other.pose) < 2e-3
        assert abs(one.pose.between(other.pose).theta) < np.radians(0.005)
        assert np.abs(np.subtract(one.controller.ticks, other.controller.ticks)).max() <= 2
        assert one.odometry.distance(other.odometry) < 2e-3
        assert one.mean_twist().linear == pytest.approx(other.mean_twist().linear, abs=2e-3)
    for body in bodies:
        body.close()


def test_both_engines_see_the_same_from_the_same_pose() -> None:
    world = {**HALL, "boxes": [{"center": [1.5, 0.3], "size": [0.4, 0.5, 0.6], "yaw": 0.4}]}
    people = [{"waypoints": [[-1.0, 1.0], [1.0, 1.5]]}]
    seen = []
    for engine in ("bullet", "plan"):
        with SimRobot(scenario(engine, world=world, people=people, robot={"sonar": True})) as robot:
            seen.append([robot.observe() for _ in range(10)][-1])
    one, other = seen
    np.testing.assert_allclose(one.scan.ranges, other.scan.ranges, atol=1.1e-3)
    np.testing.assert_allclose(one.sonar, other.sonar, atol=1e-3)
    np.testing.assert_allclose(one.people, other.people, atol=1e-9)


def drive_ahead(engine: str, seconds: float, speed: float, **changes: object) -> list[Observation]:
    with SimRobot(scenario(engine, **changes)) as robot:
        seen = []
        for k in range(round(10 * seconds)):
            robot.drive(Twist2D(speed if k < 40 else -speed, 0.0))
            observation = robot.observe()
            assert observation is not None
            seen.append(observation)
    return seen


@pytest.mark.parametrize("engine", ["bullet", "plan"])
def test_a_wall_stops_and_stalls_it_until_it_backs_off(engine: str) -> None:
    seen = drive_ahead(engine, 6.0, 0.4, world=WALL_AHEAD)
    at_wall = seen[38]
    assert at_wall.T_map_base.x == pytest.approx(0.95 - 0.21, abs=3e-3)
    assert any(s.collided for s in seen)
    assert any(s.stalled for s in seen)
    assert any(any(s.bumpers[:5]) for s in seen)
    assert not any(any(s.bumpers[5:]) for s in seen)
    assert abs(at_wall.odometry.T_odom_base.x - at_wall.T_map_base.x) < 8e-3
    assert seen[-1].T_map_base.x < 0.5
    assert not seen[-1].stalled


def test_on_a_slippery_floor_its_wheels_spin() -> None:
    last = drive_ahead("plan", 3.9, 0.4, world=WALL_AHEAD, robot={"traction": {"friction": 0.2}})[-1]
    assert last.odometry.T_odom_base.x > last.T_map_base.x + 0.1
    assert not last.stalled
    assert last.collided


def test_a_person_who_does_not_look_runs_into_it() -> None:
    people = [{"waypoints": [[2.0, 0.0], [-2.0, 0.0]], "keep": 0.0}]
    with SimRobot(scenario("plan", people=people)) as robot:
        seen = [robot.observe() for _ in range(25)]
        assert any(s.collided and any(s.bumpers[:5]) for s in seen)
        assert seen[-1].T_map_base.x == 0.0
        for _ in range(30):
            robot.drive(Twist2D(-0.3, 0.0))
            robot.observe()
        assert robot.observe().T_map_base.x < -0.3


def test_the_same_seed_gives_the_same_bits_and_another_does_not() -> None:
    robot = {"odometry": {"travel_noise": 0.02, "encoder_noise": 3.0}}
    runs = []
    for seed in (1, 1, 2):
        with SimRobot(scenario("plan", robot=robot), seed) as made:
            for _ in range(10):
                made.drive(Twist2D(0.5, 0.2))
                last = made.observe()
            runs.append(last.odometry)
    assert runs[0] == runs[1]
    assert runs[0] != runs[2]


def test_the_plan_robot_needs_no_pybullet() -> None:
    program = (
        "import sys; sys.modules['pybullet'] = None\n"
        "from sim.robot import SimRobot\nfrom slam.scenario.file import load_scenario\n"
        "with SimRobot(load_scenario('paper_simulation', ['physics.engine=plan'])) as robot: robot.observe()"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
