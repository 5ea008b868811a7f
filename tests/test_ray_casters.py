"""Both ray casters agree with each other and with the closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.ray_casters import ExactCaster
from sim.rays import fire_beams
from sim.wall_plan import CELL, SLACK, outline_edges, wall_plan
from sim.z_buffer import ROUGH, rough_bearing, stop_at_legs, stop_at_walls
from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scenario.solids import Prism, outlines_at, rectangle

HEIGHT, REACH = 0.3, 4.3
GRAZING = 2e-4
"""Radians: a ray this near an edge may hit in one caster only, as PyBullet's triangles are a little too large."""


def random_world(rng: np.random.Generator) -> list[Prism]:
    """Boxes and polygons of 3 to 12 corners, some through one another, some above or below the rays."""
    prisms = []
    for _ in range(rng.integers(1, 60)):
        corners, radius = int(rng.integers(3, 13)), rng.uniform(0.05, 1.0)
        angles = np.sort(rng.uniform(0.0, 2.0 * np.pi) + 2.0 * np.pi * np.arange(corners) / corners)
        outline = rng.uniform(-8.0, 8.0, 2) + radius * np.column_stack([np.cos(angles), np.sin(angles)])
        bottom = rng.choice([0.0, 0.5])
        prisms.append(Prism(outline, bottom, bottom + rng.uniform(0.1, 1.0)))
    prisms.append(Prism(rectangle((0.0, 9.0), 20.0, 0.1, float(rng.choice([0.0, 0.01]))), 0.0, 1.0))
    return prisms


def rays_along(origins: FloatArray, bearings: FloatArray) -> FloatArray:
    return np.vstack([origins.T, unit_vectors(bearings).T, bearings])


def brute_force(rays: FloatArray, walls: FloatArray, reach: float) -> FloatArray:
    """Every ray with every wall, from two equations in two unknowns: o + along d = s + share u."""
    ox, oy, dx, dy = rays[:4, :, None]
    sx, sy, ux, uy = walls.T
    with np.errstate(divide="ignore", invalid="ignore"):
        det = dx * uy - dy * ux
        along = ((sx - ox) * uy - (sy - oy) * ux) / det
        share = ((sx - ox) * dy - (sy - oy) * dx) / det
    hits = np.where((along >= 0.0) & (along <= reach) & (share >= 0.0) & (share <= 1.0), along, np.inf)
    return hits.min(axis=1, initial=np.inf)


def walls_of(prisms: list[Prism]) -> FloatArray:
    return np.concatenate([np.empty((0, 4)), *map(outline_edges, outlines_at(prisms, HEIGHT))])


def swept_rays(rng: np.random.Generator, speed: float, turn_speed: float) -> FloatArray:
    """Rays of a lidar with a random fan on a robot that drives along five poses."""
    step, beams = 1.0 / 60.0, int(rng.integers(2, 700))
    bearings = rng.uniform(-np.pi, np.pi) + np.linspace(0.0, rng.uniform(0.1, 2.0 * np.pi), beams)
    path = np.cumsum(np.tile([speed * step, 0.3 * speed * step, turn_speed * step], (5, 1)), axis=0)
    path += [*rng.uniform(-8.0, 8.0, 2), rng.uniform(-np.pi, np.pi)]
    rays = np.empty((5, beams))
    directions = np.ascontiguousarray(unit_vectors(bearings).T)
    fire_beams(path, step, rng.uniform(-0.3, 0.3, 2), bearings, directions, 4.0 * step / beams, rays)
    return rays


@pytest.mark.parametrize("seed", range(8))
def test_both_casters_agree_within_a_tenth_of_a_millimetre(seed: int) -> None:
    rng = np.random.default_rng(seed)
    bearings = np.concatenate([rng.uniform(-np.pi, np.pi, 3000), np.pi / 2 * np.arange(-2, 2)])
    origins = rng.uniform(-10.0, 10.0, (len(bearings), 2))
    from sim.world import BulletCaster, World  # late: PyBullet

    with World(random_world(rng), 240) as world:
        exact, bullet = ExactCaster(world.prisms, HEIGHT, REACH), BulletCaster(world, HEIGHT, REACH)
        ranges, others = (caster.cast(rays_along(origins, bearings)) for caster in (exact, bullet))
        beside = [exact.cast(rays_along(origins, bearings + angle)) for angle in (-GRAZING, GRAZING)]
    both = np.isfinite(ranges) & np.isfinite(others)
    with np.errstate(invalid="ignore"):
        smooth = [(np.isinf(ranges) & np.isinf(b)) | (abs(b - ranges) < 0.02) for b in beside]
    away = smooth[0] & smooth[1] & (abs(np.nan_to_num(ranges, posinf=9.0) - REACH) > 1e-3)
    assert away.mean() > 0.95
    assert (np.isfinite(ranges) == np.isfinite(others))[away].all()
    assert abs(ranges[both & away] - others[both & away]).max() < 1e-4
    assert both.sum() > 200


@settings(max_examples=60)
@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.5, 2.0, 30.0]), st.sampled_from([0.0, -0.8, 5.0, 25.0]))
def test_a_moving_fan_agrees_with_brute_force(seed: int, speed: float, turn_speed: float) -> None:
    rng = np.random.default_rng(seed)
    prisms, rays = random_world(rng), swept_rays(rng, speed, turn_speed)
    ranges = ExactCaster(prisms, HEIGHT, REACH).cast(rays)
    np.testing.assert_allclose(ranges, brute_force(rays, walls_of(prisms), REACH), rtol=0.0, atol=1e-9)


@settings(max_examples=15)
@given(st.integers(0, 10_000))
def test_any_rays_at_all_agree_with_brute_force(seed: int) -> None:
    rng = np.random.default_rng(seed)
    bearings = np.concatenate([rng.uniform(-np.pi, np.pi, 200), np.pi / 2 * np.arange(-2, 2)])
    prisms, rays = random_world(rng), rays_along(rng.uniform(-10.0, 10.0, (204, 2)), bearings)
    ranges = ExactCaster(prisms, HEIGHT, REACH).cast(rays)
    np.testing.assert_allclose(ranges, brute_force(rays, walls_of(prisms), REACH), rtol=0.0, atol=1e-9)


def test_a_cell_lists_all_walls_in_reach_in_any_world() -> None:
    """A hundred metres square with 2000 boxes, beside a small world and an empty one; also from just outside."""
    rng = np.random.default_rng(5)
    places, sizes = rng.uniform(0.0, 100.0, (2000, 2)).tolist(), rng.uniform(0.1, 2.0, (2000, 2)).tolist()
    large = [rectangle((x, y), length, width, 0.3) for (x, y), (length, width) in zip(places, sizes, strict=True)]
    worlds = [large, [rectangle((0.0, 0.0), 1.0, 1.0, 0.0)], []]
    plan = wall_plan(worlds, REACH)
    assert len(plan.listed) < 40 * len(plan.walls)
    for world, outlines in enumerate(worlds):
        walls = np.concatenate([np.empty((0, 4)), *map(outline_edges, outlines)])
        for middle in [*rng.uniform(-5.0, 105.0, (40, 2)), *(plan.corner[world] - [[SLACK / 2, 0.0], [CELL, CELL]])]:
            rays = rays_along(middle + rng.uniform(-0.2, 0.2, (300, 2)), np.linspace(-3.0, 3.0, 300))
            ranges = np.full(300, np.inf)
            stop_at_walls(rays, ranges, plan, world)
            ranges[ranges > REACH] = np.inf
            np.testing.assert_allclose(ranges, brute_force(rays, walls, REACH), rtol=0.0, atol=1e-9)


def test_no_ray_passes_between_two_walls_that_meet() -> None:
    outline = rectangle((0.0, 0.0), 2.0, 2.0, 0.0)
    rays = rays_along(np.zeros((8, 2)), np.pi / 4 * np.arange(8))
    rays[2:4] = np.sign(np.round(rays[2:4], 3)) / np.hypot(*np.sign(np.round(rays[2:4], 3)))
    ranges = ExactCaster([Prism(outline, 0.0, 1.0)], HEIGHT, 10.0).cast(rays)
    assert ranges == pytest.approx([1.0, np.sqrt(2.0)] * 4)


def test_a_rough_bearing_is_within_its_bound() -> None:
    bearings = np.linspace(-np.pi, np.pi, 5001)[1:-1]
    found = [rough_bearing(*point) for point in unit_vectors(bearings)]
    assert abs(found - bearings).max() < ROUGH


@pytest.mark.parametrize("caster", ["bullet", "exact"])
def test_rays_in_an_empty_world_have_no_echo(caster: str) -> None:
    from sim.world import World

    with World([], 240) as world:
        rays = rays_along(np.zeros((2, 2)), np.array([0.0, np.pi / 2]))
        assert world.caster(caster, HEIGHT, REACH).cast(rays).tolist() == [np.inf, np.inf]


def test_rays_start_where_the_sensor_is_when_the_beam_fires() -> None:
    path = np.array([[0.0, 0.0, 3.1], [0.2, 0.1, 3.3], [0.4, 0.2, -2.8]])  # the heading passes pi
    T_base_laser, angles = Pose2D(0.16, 0.02, 0.1), np.linspace(-2.0, 2.0, 9)
    beams, rays = np.ascontiguousarray(unit_vectors(angles + 0.1).T), np.empty((5, 9))
    fire_beams(path, 0.1, T_base_laser.translation, angles + 0.1, beams, 0.02, rays)
    theta = np.interp(0.02 * np.arange(9), [0.0, 0.1, 0.2], [3.1, 3.3, 2.0 * np.pi - 2.8])
    for j in range(9):
        T_map_laser = Pose2D(0.04 * j, 0.02 * j, theta[j]) @ T_base_laser
        assert rays[:2, j] == pytest.approx(T_map_laser.translation)
        bearing = T_map_laser.theta + angles[j]
        assert rays[2:4, j] == pytest.approx([np.cos(bearing), np.sin(bearing)])
        assert np.cos(rays[4, j] - bearing) == pytest.approx(1.0)


def test_a_leg_stops_the_beams_that_meet_it_when_they_fire() -> None:
    rays = rays_along(np.zeros((4, 2)), np.zeros(4))
    ranges = np.array([3.0, 3.0, 1.0, 3.0])
    legs = np.array([[[2.0, 0.0]], [[2.0, 0.3]]])  # it steps aside between two rows of the path
    stop_at_legs(rays, ranges, legs, np.array([0.1]), 0.25)
    assert ranges == pytest.approx([1.9, 2.0 - np.sqrt(0.1**2 - 0.075**2), 1.0, 3.0])


@settings(max_examples=40)
@given(st.integers(0, 10_000))
def test_legs_stop_a_fan_as_the_quadratic_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rays = swept_rays(rng, 1.0, 1.0)
    beams = rays.shape[1]
    centre = rays[:2].mean(axis=1)
    legs = centre + rng.uniform(-2.0, 2.0, (1, 6, 2)) + np.array([0.0, 0.05, 0.1])[:, None, None]
    radii = rng.uniform(0.02, 0.2, 6)
    ranges = np.full(beams, 5.0)
    stop_at_legs(rays, ranges, legs, radii, 2.0 / beams)
    share = np.arange(beams) * 2.0 / beams
    expected = np.full(beams, 5.0)
    for leg in range(6):
        places = np.column_stack([np.interp(share, range(3), legs[:, leg, axis]) for axis in range(2)])
        to_leg = places - rays[:2].T
        b, c = (to_leg * rays[2:4].T).sum(axis=1), (to_leg**2).sum(axis=1) - radii[leg] ** 2
        root = b - np.sqrt(np.maximum(b * b - c, 0.0))
        hit = (b * b > c) & (b > 0.0)
        expected[hit] = np.minimum(expected[hit], np.maximum(root[hit], 0.0))
    np.testing.assert_allclose(ranges, expected, atol=1e-9)
