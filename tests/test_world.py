"""The world: what rays hit, which bodies touch, and who owns a physics server."""

from typing import Any

import numpy as np
import pytest

from sim.bullet import pybullet
from sim.p3dx import P3dx
from sim.world import World
from slam.assets import asset
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.scenario.furniture import Box
from slam.scenario.robot_config import RobotConfig
from slam.scenario.solids import Prism, rectangle
from slam.scenario.world_plan import World as Plan


def prisms(*boxes: Box) -> list[Prism]:
    return Plan(boxes=boxes).prisms()


BOX = Box(center=(3.0, 0.5), size=(1.0, 2.0, 0.8))


def ray(world: World, start: tuple[float, float, float], end: tuple[float, float, float]) -> float:
    """Metres until the ray meets something."""
    origins, ends = np.array([start]), np.array([end])
    return float(world.cast(origins, ends)[0] * np.linalg.norm(ends - origins))


@pytest.mark.parametrize(
    ("start", "end", "distance"),
    [
        ((0.0, 0.0, 0.3), (10.0, 0.0, 0.3), 2.5),
        ((10.0, 1.4999, 0.3), (0.0, 1.4999, 0.3), 6.5),
        ((3.2, 5.0, 0.7999), (3.2, -5.0, 0.7999), 3.5),
        ((3.0, 0.5, 3.0), (3.0, 0.5, 0.0), 2.2),
        ((0.0, 0.0, 0.8005), (10.0, 0.0, 0.8005), np.inf),
        ((0.0, 1.5005, 0.3), (10.0, 1.5005, 0.3), np.inf),
        ((0.0, 0.0, 0.3), (2.4999, 0.0, 0.3), np.inf),
    ],
)
def test_rays_meet_a_box_within_a_tenth_of_a_millimetre(start: Any, end: Any, distance: float) -> None:
    with World(prisms(BOX), rate=240) as world:
        assert ray(world, start, end) == pytest.approx(distance, abs=1e-4)


def test_rays_meet_a_turned_box() -> None:
    with World(prisms(Box(center=(2.0, 0.0), size=(1.0, 1.0, 1.0), yaw=np.pi / 4)), rate=240) as world:
        assert ray(world, (0.0, 0.1, 0.3), (5.0, 0.1, 0.3)) == pytest.approx(2.0 - np.sqrt(0.5) + 0.1, abs=1e-4)


def test_no_ray_of_a_large_batch_is_lost() -> None:
    angles = np.linspace(-np.pi, np.pi, 40_000)
    center = np.tile([3.0, 0.5, 0.3], (len(angles), 1))
    around = center + 9.0 * np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
    with World(prisms(BOX), rate=240) as world:
        fractions = world.cast(around, center)
    assert fractions.shape == (40_000,)
    assert np.isfinite(fractions).all()
    assert (fractions > 0.8).all()


def test_rays_in_an_empty_world_meet_nothing() -> None:
    with World([], rate=240) as world:
        assert ray(world, (0.0, 0.0, 0.3), (10.0, 0.0, 0.3)) == np.inf
        assert P3dx(world, RobotConfig()).near() == ()


def test_rays_pass_through_the_robot() -> None:
    with World(prisms(BOX), rate=240) as world:
        P3dx(world, RobotConfig(start={"x": 1.0}))
        world.step()
        assert ray(world, (0.0, 0.0, 0.15), (10.0, 0.0, 0.15)) == pytest.approx(2.5, abs=1e-4)


def test_a_closed_world_does_not_affect_later_worlds() -> None:
    closed = World([], rate=240)
    closed.close()
    closed.close()
    with World([], rate=240), pytest.raises(RobotError, match="closed"):
        closed.step()


def open_clients() -> int:
    return sum(pybullet.getConnectionInfo(physicsClientId=client)["isConnected"] for client in range(1024))


def test_unreferenced_worlds_are_freed_or_reused() -> None:
    before = open_clients()
    for _ in range(5):
        world = World([], rate=240)
        del world
    assert open_clients() <= before + 1
    worlds = [World([], rate=240) for _ in range(3)]
    assert open_clients() >= 3
    for world in worlds:
        world.close()
    assert open_clients() <= before + 1


def test_a_world_on_a_server_that_was_used_before_is_empty() -> None:
    World(prisms(BOX), rate=100).close()
    with World([], rate=240) as world:
        assert ray(world, (0.0, 0.5, 0.3), (10.0, 0.5, 0.3)) == np.inf


@pytest.mark.parametrize(("height", "stops"), [(0.02, False), (0.03, True)])
def test_a_sill_stops_the_robot_from_25_millimetres_on(height: float, stops: bool) -> None:
    with World(prisms(Box(center=(0.6, 0.0), size=(0.2, 2.0, height))), rate=240) as world:
        base = P3dx(world, RobotConfig(control_rate=240))
        touched = False
        for _ in range(960):
            base.controller.command(Twist2D(0.3, 0.0))
            base.control()
            world.step()
            touched |= bool(base.contacts(base.near()))
    assert touched == stops


def test_an_error_of_pybullet_is_a_robot_error_with_its_cause() -> None:
    with World([], rate=240) as world, pytest.raises(RobotError, match="rayTestBatch") as caught:
        world.cast(np.zeros((1, 3)), np.zeros((1, 2)))
    assert caught.value.__cause__ is not None


def test_a_missing_asset_is_named() -> None:
    assert asset("urdf/p3dx.urdf").read_text().startswith("<?xml")
    with pytest.raises(RobotError, match=r"urdf/p4dx\.urdf"):
        asset("urdf/p4dx.urdf")


def test_overlapping_fixed_objects_take_no_time() -> None:
    with World([Prism(rectangle((0.0, 0.0), 2.0, 2.0, 0.0), 0.0, 1.0)], 240) as world:
        for pillar in [world.add_pillar(0.06, 0.85) for _ in range(4)][:2]:
            world.move(pillar, 0.0, 0.0, 0.4)
        world.step()
        assert world.bullet.call(pybullet.getContactPoints) == ()
