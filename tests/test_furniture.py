"""Pushable furniture moves as its mass allows, is seen where it is, and is put back by a restart."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim.bench.stall_drives import FORWARD, drive, scene, wall
from sim.furniture import friction_arm
from sim.moving_outlines import MovingOutlines
from sim.plant import SimPlant
from sim.robot import SimRobot
from sim.wall_plan import wall_plan
from sim.z_buffer import stop_at_walls
from slam.env.p3dx_env import P3DXEnv
from slam.pose import Pose2D
from slam.run.experiment_setup import scenario_experiment
from slam.scenario.furniture import Box, Cylinder, Table, movable
from slam.scenario.schema import Scenario
from slam.scenario.solids import Prism, clearance, disc, rectangle
from slam.scenario.world_plan import World

PIECES = (
    Box(center=(1.0, 2.0), size=(0.5, 0.3, 0.6), yaw=0.4, mass=3.0),
    Table(center=(-1.0, 0.5), yaw=-1.0, mass=8.0),
    Cylinder(center=(0.3, -1.0), radius=0.2, mass=2.0),
)
HEIGHT = 0.3


def test_furniture_starts_as_the_solid_of_the_plan() -> None:
    for piece in PIECES:
        thing = movable(piece)
        for own, planned in zip(thing.prisms, piece.prisms(), strict=True):
            np.testing.assert_allclose(
                np.sort(thing.T_map_thing.transform(own.footprint), axis=0),
                np.sort(planned.footprint, axis=0),
                atol=1e-3,
            )
            assert (own.bottom, own.top) == (planned.bottom, planned.top)


def test_only_furniture_with_a_mass_can_be_pushed() -> None:
    fixed = Box(center=(3.0, 0.0), size=(1.0, 1.0, 1.0))
    world = World(boxes=(PIECES[0], fixed), tables=(PIECES[1],), cylinders=(PIECES[2],))
    assert [thing.mass for thing in world.movables()] == [3.0, 8.0, 2.0]
    assert len(world.fixed_prisms()) == 1
    assert len(world.prisms()) == 1 + 1 + 5 + 1


@pytest.mark.parametrize("seed", range(5))
def test_rays_meet_moved_outlines_as_they_meet_fixed_ones(seed: int) -> None:
    rng = np.random.default_rng(seed)
    things = [movable(piece) for piece in PIECES]
    places = np.column_stack([rng.uniform(-2.0, 2.0, (3, 2)), rng.uniform(-9.0, 9.0, 3)])
    bearings = rng.uniform(-np.pi, np.pi, 500)
    rays = np.vstack([rng.uniform(-3.0, 3.0, (2, 500)), np.cos(bearings), np.sin(bearings), bearings])
    outlines = [
        Pose2D(*place).transform(prism.footprint)
        for place, thing in zip(places.tolist(), things, strict=True)
        for prism in thing.prisms
        if prism.bottom <= HEIGHT <= prism.top
    ]
    ranges = np.full(500, np.inf)
    MovingOutlines(things, HEIGHT).stop(rays, ranges, places[None], 0.0)
    fixed = np.full(500, np.inf)
    stop_at_walls(rays, fixed, wall_plan([outlines], np.inf), 0)
    np.testing.assert_allclose(ranges, fixed, atol=1e-9)
    assert np.isfinite(ranges).sum() > 20


def test_beams_meet_moving_furniture_at_their_own_time() -> None:
    box = movable(Box(center=(0.0, 0.0), size=(1.0, 1.0, 1.0), mass=1.0))
    assert box is not None
    outlines = MovingOutlines([box], HEIGHT)
    places = np.array([[[2.0, 0.0, 3.1]], [[2.2, 0.0, 3.1 - 2.0 * np.pi]]])
    ranges = np.full(4, 9.0)
    rays = np.tile([[0.0], [0.0], [1.0], [0.0], [0.0]], 4)
    outlines.stop(rays, ranges, places, 0.25)
    half = 0.5 / np.cos(np.pi - 3.1)
    np.testing.assert_allclose(ranges, [2.0 - half, 2.05 - half, 2.1 - half, 2.15 - half])


def pushed(mass: float, **parts: object) -> SimRobot:
    thing = {"center": [0.6, 0.0], "radius": 0.2, "mass": mass}
    return SimRobot(scene(wall(0.0, at=4.0) | {"cylinders": [thing]}, **parts))


def go(robot: SimRobot, scans: int) -> list[Any]:
    seen = []
    for _ in range(scans):
        robot.drive(FORWARD)
        seen.append(robot.observe())
    return seen


@pytest.mark.parametrize(("mass", "moves"), [(1.0, True), (6.0, True), (12.0, False), (50.0, False)])
def test_the_robot_pushes_with_25_newtons_or_stalls(mass: float, moves: bool) -> None:
    """The robot pushes 8 kg at most where the friction on the floor is 0.3."""
    with pushed(mass) as robot:
        seen = go(robot, 60)
        way = robot.furniture[0, 0] - 0.6
    assert seen[-1].stalled != moves
    assert way > 0.5 if moves else way < 0.02
    assert any(s.bumpers[2] for s in seen)
    assert not any(s.collided for s in seen)
    assert seen[-1].odometry.T_odom_base.distance(seen[-1].T_map_base) < 0.02


def in_the_way(mass: float, duration: float) -> Scenario:
    """A room in which the straight way to x = 2 m leads past a box that it touches."""
    room = [{"points": [[-1.0, -2.0], [5.0, -2.0], [5.0, 2.0], [-1.0, 2.0]], "closed": True}]
    box = {"center": [1.0, 0.3], "size": [0.4, 0.4, 0.5], "mass": mass}
    route = {"waypoints": [[2.0, 0.0]], "speed": 0.4}
    return scene({"walls": room, "boxes": [box]}, route=route, duration=duration, slam={"mode": "dead_reckoning"})


@pytest.mark.parametrize(("mass", "duration", "ending"), [(3.0, 30.0, "arrived"), (50.0, 8.0, "duration over")])
def test_touching_pushable_furniture_does_not_end_a_run(
    mass: float, duration: float, ending: str, tmp_path: Path
) -> None:
    assert scenario_experiment(in_the_way(mass, duration)).run(tmp_path / "run", pictures=False).ending == ending


@pytest.mark.parametrize(("mass", "goes_on"), [(3.0, True), (50.0, False)])
def test_pushing_ends_no_episode_but_a_stall_does(mass: float, goes_on: bool) -> None:
    env = P3DXEnv(in_the_way(mass, 30.0), reward="none", end_on="collision")
    env.reset(seed=0)
    for _ in range(45):
        *_, terminated, _, info = env.step(np.array([0.3, 0.0], np.float32))
        if terminated:
            break
    env.close()
    assert terminated != goes_on
    assert info["observation"].stalled != goes_on
    assert not info["observation"].collided


def test_a_pushing_robot_still_collides_with_a_wall() -> None:
    things = {"boxes": [{"center": [0.6, 0.2], "size": [0.2, 0.2, 0.5], "mass": 1.0}]}
    with SimRobot(scene(wall(0.0, at=1.5) | things)) as robot:
        seen = go(robot, 60)
    first = next(n for n, s in enumerate(seen) if any(s.bumpers))
    collision = next(n for n, s in enumerate(seen) if s.collided)
    assert collision > first + 5


OFF_CENTRE = (
    {"cylinders": [{"center": [0.7, 0.05], "radius": 0.15, "mass": 20.0}]},
    {"cylinders": [{"center": [0.8, -0.12], "radius": 0.3, "mass": 20.0}]},
    {"tables": [{"center": [0.9, 0.25], "size": [0.8, 0.5, 0.7], "mass": 20.0}]},
    {"boxes": [{"center": [0.7, 0.1], "size": [0.4, 0.4, 0.5], "mass": 20.0}]},
)


@pytest.mark.parametrize("things", OFF_CENTRE)
def test_too_heavy_furniture_does_not_move(things: Any) -> None:
    with SimRobot(scene(wall(0.0, at=4.0) | things)) as robot:
        start = robot.furniture
        go(robot, 200)
        assert np.abs(robot.furniture - start).max() < 0.015


@pytest.mark.parametrize(("mass", "turns"), [(8.0, True), (40.0, False)])
def test_furniture_pushed_off_centre_turns_by_its_friction(mass: float, turns: Any) -> None:
    """A force of 25 N, 0.4 m from the middle, overcomes the friction of a rod of 1 m if its mass is below 14 kg.

    The friction resists a turn by 0.3 m g / 4.
    """
    rod = {"center": [0.6, 0.4], "size": [0.1, 1.0, 0.5], "mass": mass}
    with SimRobot(scene(wall(0.0, at=4.0) | {"boxes": [rod]})) as robot:
        go(robot, 100)
        angle = robot.furniture[0, 2]
    assert angle > 0.5 if turns else abs(angle) < 0.02


@pytest.mark.parametrize(
    ("footprint", "arm"),
    [
        (disc((0.0, 0.0), 0.3), 0.2),
        (rectangle((0.0, 0.0), 1.0, 1.0, 0.0), (np.sqrt(2.0) + np.log(1.0 + np.sqrt(2.0))) / 6.0),
        (rectangle((0.0, 0.0), 1e-3, 2.0, 0.0), 0.5),
        (rectangle((3.0, 4.0), 0.01, 0.01, 0.3), 5.0),
    ],
)
def test_the_friction_arm_is_the_mean_distance_of_the_footprint(footprint: Any, arm: float) -> None:
    above = Prism(rectangle((9.0, 0.0), 1.0, 1.0, 0.0), 0.5, 1.0)
    assert friction_arm([Prism(footprint, 0.0, 1.0), above]) == pytest.approx(arm, rel=4e-3)


@pytest.mark.parametrize("caster", ["bullet", "exact"])
def test_lidar_and_sonar_see_moved_furniture(caster: str) -> None:
    lidar = {"caster": caster, "noise": "none", "rolling": False, "model": "urg04lx"}
    with pushed(2.0, lidar=lidar, robot={"sonar": True}) as robot:
        go(robot, 50)
        for _ in range(20):
            robot.drive(type(FORWARD)(-0.3))
            seen = robot.observe()
        x, y, _ = robot.furniture[0]
    points = (seen.T_map_base @ robot.T_base_laser).transform(seen.scan.points())
    away = np.hypot(points[:, 0] - x, points[:, 1] - y)
    assert x > 1.0
    assert (away < 0.202).sum() > 20
    assert away.min() > 0.198
    assert min(seen.sonar[3:5]) == pytest.approx(x - 0.2 - seen.T_map_base.x - 0.166, abs=0.03)


def test_furniture_pushed_against_a_wall_stops_the_robot() -> None:
    thing = {"center": [0.8, 0.0], "radius": 0.2, "mass": 2.0}
    with SimRobot(scene(wall(0.0, at=1.5) | {"cylinders": [thing]})) as robot:
        seen = go(robot, 80)
        assert robot.furniture[0, 0] == pytest.approx(1.45 - 0.2, abs=0.01)
    assert seen[-1].stalled


def test_untouched_furniture_does_not_move() -> None:
    world = wall(0.0, at=4.0) | {"tables": [{"center": [2.0, 1.0], "yaw": 0.3, "mass": 5.0}]}
    with SimRobot(scene(world)) as robot:
        before = robot.furniture
        go(robot, 50)
        np.testing.assert_allclose(robot.furniture, before, atol=1e-6)


def test_a_restart_puts_furniture_back_exactly() -> None:
    pieces = [{"center": [0.6, y], "size": [0.3, 0.2, 0.5], "mass": 1.0} for y in (-0.12, 0.12)]
    world = wall(0.0, at=2.0) | {"boxes": pieces, "cylinders": [{"center": [1.2, 0.0], "radius": 0.1, "mass": 1.0}]}
    people = [{"waypoints": [[1.6, 1.0], [1.6, -1.0]]}]

    def run(robot: SimRobot) -> bytes:
        seen = go(robot, 60)
        return robot.furniture.tobytes() + repr([(s.T_map_base, s.odometry, s.stalled) for s in seen]).encode()

    scenario = scene(world, people=people, robot={"odometry": {"travel_noise": 0.01}})
    with SimRobot(scenario, 3) as robot, SimRobot(scenario, 3) as fresh:
        start = robot.furniture
        first = run(robot)
        assert np.abs(robot.furniture - start).max() > 0.2
        robot.restart(3)
        assert robot.furniture.tobytes() == start.tobytes()
        assert run(robot) == first == run(fresh)


def test_a_light_mat_is_driven_over() -> None:
    world = wall(0.0, at=9.0) | {"boxes": [{"center": [1.0, 0.0], "size": [0.5, 0.5, 0.02], "mass": 0.5}]}
    driven = drive(scene(world), seconds=6.0)
    assert driven.truth[-1, 0] > 1.5


def test_the_emulated_plant_has_furniture() -> None:
    thing = {"center": [0.6, 0.0], "radius": 0.2, "mass": 2.0}
    plant = SimPlant(scene(wall(0.0, at=4.0) | {"cylinders": [thing]}))
    assert plant.ranges(np.zeros(1))[0] == pytest.approx(0.6 - 0.2 - 0.16, abs=2e-3)
    for _ in range(400):
        plant.advance(0.01, FORWARD)
    for _ in range(200):
        plant.advance(0.01, type(FORWARD)(-0.3))
    assert plant.T_map_base.x > 0.4
    behind = 1.2 - 0.21 - 0.16  # it stands where the front of the robot left it
    assert 0.4 < plant.ranges(np.zeros(1))[0] < behind


def test_furniture_is_an_obstacle_at_its_start() -> None:
    world = World(cylinders=(PIECES[2],))
    assert clearance(np.array([[0.3, -0.7]]), [p.footprint for p in world.prisms()])[0] == pytest.approx(0.1, abs=2e-3)
