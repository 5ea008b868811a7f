"""A blocked base: its motors stall; on a slippery floor its wheels spin instead."""

from math import radians
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from sim.bench.stall_drives import CASES, drive, scene, sill, sill_outcome, wall
from sim.controller import Controller
from sim.firmware import MOTOR_TORQUE, RECOVERY_TIME, STALL_TIME
from sim.plant import SimPlant
from sim.robot import SimRobot
from sim.wheels import WHEEL_RADIUS
from sim.world import GRAVITY
from slam.assets import asset
from slam.env.p3dx_env import P3DXEnv
from slam.odometry import Twist2D
from slam.scenario.robot_config import RobotConfig

CASTER = 0.211
"""Distance from the axle back to the contact point of the caster, metres."""


def controller_at(rate: int) -> Controller:
    return Controller(RobotConfig(control_rate=rate), rate)


def push(controller: Controller, steps: int, speeds: tuple[float, float], torques: tuple[float, float]) -> None:
    """Make control steps in which the rims have these speeds, m/s, and the motors these shares of their full torque."""
    left, right = ((0.0, v / WHEEL_RADIUS, (), MOTOR_TORQUE * t) for v, t in zip(speeds, torques, strict=True))
    for _ in range(steps):
        controller.read_wheels(left, right)


def is_engaged(controller: Controller) -> bool:
    return controller.motors[2] == MOTOR_TORQUE


@pytest.mark.parametrize("rate", [10, 60, 240])
def test_motors_are_switched_off_by_a_stall_and_recover(rate: Any) -> None:
    controller = controller_at(rate)
    push(controller, round(STALL_TIME * rate) - 1, (0.0, 0.0), (1.0, 1.0))
    assert is_engaged(controller)
    assert not controller.stalled
    push(controller, 1, (0.0, 0.0), (1.0, 1.0))
    assert controller.stalled
    assert not is_engaged(controller)
    push(controller, round(RECOVERY_TIME * rate), (0.0, 0.0), (0.0, 0.0))
    assert controller.stalled
    assert is_engaged(controller)


@pytest.mark.parametrize(
    ("speeds", "torques", "stalls"),
    [
        ((0.0, 0.0), (1.0, -1.0), True),  # on the spot, in a corner
        ((0.0, 0.0), (1.0, 0.2), True),  # one motor is told to hold still
        ((0.1, 0.0), (1.0, 1.0), True),  # one wheel slips under full torque
        ((-0.1, 0.3), (1.0, 0.3), False),  # it swings around a corner that it has met
        ((0.0, 0.0), (0.5, 0.5), False),  # it stands uphill
        ((0.3, 0.3), (1.0, 1.0), False),  # it gathers speed
    ],
)
def test_motors_stall_when_a_wheel_stands_under_load(speeds: Any, torques: Any, stalls: bool) -> None:
    controller = controller_at(60)
    push(controller, 60, speeds, torques)
    assert controller.stalled == stalls


def test_a_stall_is_over_once_the_motors_have_worked() -> None:
    controller = controller_at(60)
    push(controller, round((STALL_TIME + RECOVERY_TIME) * 60), (0.0, 0.0), (1.0, 1.0))
    push(controller, 3, (0.0, 0.0), (0.3, 0.3))
    assert controller.stalled
    push(controller, round(STALL_TIME * 60), (0.3, 0.3), (0.1, 0.1))
    assert not controller.stalled


@pytest.mark.parametrize("case", CASES)
def test_a_blocked_base_stalls_and_its_odometry_stops(case: str) -> None:
    driven = drive(scene(**CASES[case]))
    assert driven.stalled_at - driven.stood_at < 0.7
    metres, turn = driven.odometry_after_stall
    assert metres < 0.02
    assert turn < 0.02
    first = int(np.flatnonzero(driven.stalled)[0])
    assert driven.seconds[-1] - driven.seconds[first] > 8.0
    assert driven.stalled[first:].all()


@pytest.mark.parametrize("speed", [0.1, 0.6, 1.2, -0.3])
@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_a_base_stalls_at_any_speed_and_in_reverse(speed: float, angle: float) -> None:
    at = 1.0 if speed < 0.5 else 2.0
    driven = drive(scene(wall(radians(angle), at=at if speed > 0 else -0.6)), Twist2D(speed), seconds=11.0)
    assert driven.stalled_at - driven.stood_at < 0.7
    assert driven.odometry_after_stall[0] < 0.02
    assert driven.odometry_after_stall[1] < 0.02


@pytest.mark.parametrize("turn", [0.8, -0.8])
def test_a_base_that_turns_on_the_spot_between_walls_stalls(turn: float) -> None:
    walls = [{"points": [[-2.0, y], [2.0, y]]} for y in (0.27, -0.27)]
    driven = drive(scene({"walls": walls}), Twist2D(0.0, turn), seconds=5.0)
    assert driven.stalled_at < 1.5
    assert driven.odometry_after_stall[1] < 0.01


def test_a_grazed_wall_leaves_the_odometry_true() -> None:
    driven = drive(scene(wall(radians(80.0), at=3.0, length=6.0)), seconds=12.0)
    assert not driven.stalled.any()
    ways = [np.hypot(*np.diff(poses[:, :2], axis=0).T).sum() for poses in (driven.truth, driven.odometry)]
    assert ways[0] == pytest.approx(ways[1], rel=0.05)
    assert ways[0] > 3.0


def test_a_stalled_base_can_reverse_free() -> None:
    with SimRobot(scene(wall(0.0))) as robot:
        for _ in range(60):
            robot.drive(Twist2D(0.3))
            stalled = robot.observe()
        for _ in range(20):
            robot.drive(Twist2D(-0.3))
            free = robot.observe()
    assert stalled.stalled
    assert not free.stalled
    assert free.T_map_base.x < stalled.T_map_base.x - 0.3


def test_the_base_continues_when_a_person_leaves() -> None:
    passer_by = {"waypoints": [[1.2, 2.5], [1.2, 0.0]], "pause": 4.0, "keep": 0.0, "stride": 0.2}
    driven = drive(scene(wall(0.0, at=9.0), people=[passer_by]), seconds=11.0)
    assert driven.stalled[60]
    assert not driven.stalled[-1]
    assert driven.truth[-1, 0] > driven.truth[60, 0] + 0.5


@pytest.mark.parametrize("height", range(5, 41))
def test_a_sill_up_to_25_mm_is_driven_over(height: float) -> None:
    outcome = sill_outcome(scene(sill(height / 1000.0)))
    assert outcome == ("over" if height <= 25 else "stopped")


@pytest.mark.parametrize("height", [0.024, 0.0249, 0.0251, 0.026])
@pytest.mark.parametrize("box", [{"yaw": 0.5}, {"center": [0.6, 1.05], "size": [0.1, 2.0]}, {"size": [0.005, 4.0]}])
def test_the_base_is_not_stuck_on_slanting_or_thin_sills(height: float, box: Any) -> None:
    changed = box | {"size": [*box.get("size", [0.1, 4.0]), height]}
    assert sill_outcome(scene(sill(height, **changed))) == ("over" if height <= 0.025 else "stopped")


def grip_needed(height: float) -> float:
    """Return the least coefficient of friction at which wheels under full torque do not slip at an obstacle.

    The obstacle pushes back ``height`` metres above the floor; this moves load from the axle to the caster.
    """
    links = ElementTree.parse(asset("urdf/p3dx.urdf")).findall("link")
    mass = {link.get("name"): float(link.find("inertial/mass").get("value")) for link in links}
    behind = (0.06 * mass["base_link"] + CASTER * mass["caster"]) / sum(mass.values())
    force = 2.0 * MOTOR_TORQUE / WHEEL_RADIUS
    return force / (sum(mass.values()) * GRAVITY * (1.0 - behind / CASTER) - force * height / CASTER)


@pytest.mark.parametrize(("share", "stalls"), [(0.95, False), (1.07, True)])
def test_wheels_spin_on_a_slippery_floor_else_stall(share: float, stalls: bool) -> None:
    """The obstacle is a low sill, which pushes at a height between 10 and 30 mm."""
    slippery = {"traction": {"friction": share * grip_needed(0.01 if share < 1.0 else 0.03)}}
    driven = drive(scene(sill(0.03), robot=slippery), seconds=6.0)
    assert driven.stalled.any() == stalls
    spun = driven.odometry[-1, 0] - driven.truth[-1, 0]
    assert spun < 0.05 if stalls else spun > 0.5


def test_the_emulators_plant_stalls_and_scans_in_place() -> None:
    plant = SimPlant(scene(wall(0.0)))
    for _ in range(600):
        plant.advance(0.01, Twist2D(0.3))
    before = plant.odometry.x
    for _ in range(400):
        plant.advance(0.01, Twist2D(0.3))
    assert plant.stalled
    assert plant.odometry.x == pytest.approx(before, abs=0.005)
    later, now = plant.ranges(np.zeros(1), ahead=0.2), plant.ranges(np.zeros(1))
    assert later[0] == pytest.approx(now[0], abs=0.005)
    for _ in range(100):
        plant.advance(0.01, Twist2D(-0.2))
    assert not plant.stalled


def test_info_reports_a_stall_if_collisions_do_not_end() -> None:
    env = P3DXEnv(scene(wall(0.0, at=0.6)), reward="none", end_on=())
    env.reset(seed=0)
    for _ in range(30):
        *_, info = env.step(np.array([0.3, 0.0], np.float32))
    assert info["observation"].stalled
    env.close()
