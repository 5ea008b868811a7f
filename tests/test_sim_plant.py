"""The PyBullet world behind the emulated devices: the simulated robot without its firmware."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from hardware.arcos.model import P3DX_SH
from hardware.arcos.packet import PacketDecoder
from hardware.arcos.sip import Sip
from hardware.emulator.p3dx import FACTORY_CONFIG, EmulatedP3dx
from sim.plant import SimPlant
from slam.errors import ScenarioError
from slam.odometry import Twist2D
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

WALL_AHEAD = {"walls": [{"points": [[1.0, -2.0], [1.0, 2.0]]}]}


def plant(**changes: object) -> SimPlant:
    return SimPlant(Scenario(name="test", world=WALL_AHEAD, **({"lidar": {"noise": "none"}} | changes)))


def drive(moved: SimPlant, seconds: float, twist: Twist2D) -> None:
    """Drive, with a ramp of half a second up to this speed."""
    for k in range(round(100 * seconds)):
        share = min(1.0, k / 50)
        moved.advance(0.01, Twist2D(share * twist.linear, share * twist.angular))


def test_the_plant_moves_as_its_wheels_turn() -> None:
    wheels = {"left_radius": 0.0975, "right_radius": 0.0985, "track": 0.34}
    moved = plant(robot={"odometry": wheels})
    drive(moved, 2.0, Twist2D(0.2, 0.5))
    assert moved.odometry.theta == pytest.approx(0.875, abs=0.03)
    left, right = moved.travel
    assert (right - left) / 0.34 == pytest.approx(moved.odometry.theta, abs=1e-6)
    truly = (right * 0.0975 / 0.0985 - left) / 0.33
    assert moved.T_map_base.theta == pytest.approx(truly, abs=2e-3)


def test_the_lidar_sees_the_wall_from_its_pose() -> None:
    moved = plant()
    bearings = np.array([0.0, pi / 2])
    assert moved.ranges(bearings)[0] == pytest.approx(0.95 - 0.16, abs=1e-3)
    assert moved.ranges(bearings)[1] == np.inf
    drive(moved, 1.0, Twist2D(0.3, 0.0))
    assert moved.ranges(bearings)[0] == pytest.approx(0.95 - 0.16 - moved.T_map_base.x, abs=1e-3)


def test_bumpers_stall_and_sonar_are_in_the_reports() -> None:
    robot = EmulatedP3dx(plant(robot={"sonar": True}), config=replace(FACTORY_CONFIG, watchdog=0.0))
    robot.open = True
    (free,) = reports(robot, 0.1)
    assert dict(free.sonar)[3] == pytest.approx(0.95 - 0.166, abs=0.02)
    assert dict(free.sonar)[0] == 5.0
    robot.motors.enable(True)
    robot.motors.set_targets(linear=0.3)
    blocked = reports(robot, 5.0)[-1]
    assert blocked.stalled
    assert blocked.front_bumpers
    assert not blocked.rear_bumpers


def reports(robot: EmulatedP3dx, seconds: float) -> list[Sip]:
    until, said = robot.due + seconds - 1e-9, b""
    while robot.due < until:
        said += robot.step()
    return [Sip.decode(packet, P3DX_SH) for packet in PacketDecoder().feed(said)]


def test_an_empty_world_is_refused() -> None:
    with pytest.raises(ScenarioError, match="nothing to see"):
        SimPlant(load_scenario("replay"))
