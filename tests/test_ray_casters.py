"""Both ray casters: each other's equal, and the closed form's."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.ray_casters import BulletCaster, ExactCaster
from sim.rays import rays_of, stop_at_legs
from sim.world import World
from slam.pose import FloatArray, Pose2D
from slam.scenario.solids import Prism, rectangle

HEIGHT, REACH = 0.3, 4.3
GRAZING = 2e-4
"""Radians: a ray this near the edge of something may be taken differently, as PyBullet's triangles reach too far."""


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


def turned(directions: FloatArray, angle: float) -> FloatArray:
    return Pose2D(0.0, 0.0, angle).transform(directions)


@pytest.mark.parametrize("seed", range(8))
def test_both_casters_agree_within_a_tenth_of_a_millimetre(seed):
    rng = np.random.default_rng(seed)
    bearings = np.concatenate([rng.uniform(-np.pi, np.pi, 3000), np.pi / 2 * np.arange(-2, 2)])
    directions = np.column_stack([np.cos(bearings), np.sin(bearings)])
    origins = rng.uniform(-10.0, 10.0, directions.shape)
    with World(random_world(rng), 240) as world:
        exact, bullet = ExactCaster(world, HEIGHT, REACH), BulletCaster(world, HEIGHT, REACH)
        ranges, others = exact.cast(origins, directions), bullet.cast(origins, directions)
        beside = [exact.cast(origins, turned(directions, angle)) for angle in (-GRAZING, GRAZING)]
    both = np.isfinite(ranges) & np.isfinite(others)
    with np.errstate(invalid="ignore"):
        smooth = [(np.isinf(ranges) & np.isinf(b)) | (abs(b - ranges) < 0.02) for b in beside]
    away = smooth[0] & smooth[1] & (abs(np.nan_to_num(ranges, posinf=9.0) - REACH) > 1e-3)
    assert away.mean() > 0.95
    assert (np.isfinite(ranges) == np.isfinite(others))[away].all()
    assert abs(ranges[both & away] - others[both & away]).max() < 1e-4
    assert both.sum() > 200


@settings(max_examples=25)
@given(st.integers(0, 10_000))
def test_the_grid_loses_no_wall(seed):
    """Against every ray with every segment, in plain numpy."""
    rng = np.random.default_rng(seed)
    bearings = np.concatenate([rng.uniform(-np.pi, np.pi, 200), np.pi / 2 * np.arange(-2, 2)])
    directions = np.column_stack([np.cos(bearings), np.sin(bearings)])
    origins = rng.uniform(-10.0, 10.0, directions.shape)
    with World(random_world(rng), 240) as world:
        caster = ExactCaster(world, HEIGHT, REACH)
    sx, sy, ux, uy = caster._grid.segments.T
    (ox, oy), (dx, dy) = (column.T[:, :, None] for column in (origins, directions))
    with np.errstate(divide="ignore", invalid="ignore"):
        det = dx * uy - dy * ux
        along = ((sx - ox) * uy - (sy - oy) * ux) / det
        share = ((sx - ox) * dy - (sy - oy) * dx) / det
    hits = np.where((along >= 0.0) & (along <= REACH) & (share >= 0.0) & (share <= 1.0), along, np.inf)
    np.testing.assert_allclose(caster.cast(origins, directions), hits.min(axis=1), atol=1e-9)


@pytest.mark.parametrize("caster", [BulletCaster, ExactCaster])
def test_in_an_empty_world_there_is_nothing(caster):
    with World([], 240) as world:
        assert caster(world, HEIGHT, REACH).cast(np.zeros((2, 2)), np.eye(2)).tolist() == [np.inf, np.inf]


def test_rays_start_where_the_sensor_is_when_the_beam_fires():
    path = np.array([[0.0, 0.0, 3.1], [0.2, 0.1, 3.3], [0.4, 0.2, -2.8]])  # over the end of the circle
    T_base_laser, angles = Pose2D(0.16, 0.02, 0.1), np.linspace(-2.0, 2.0, 9)
    beams = np.column_stack([np.cos(angles + 0.1), np.sin(angles + 0.1)])
    origins, directions = rays_of(path, 0.1, T_base_laser.translation, beams, 0.02)
    theta = np.interp(0.02 * np.arange(9), [0.0, 0.1, 0.2], [3.1, 3.3, 2.0 * np.pi - 2.8])
    for j in range(9):
        T_map_laser = Pose2D(0.04 * j, 0.02 * j, theta[j]) @ T_base_laser
        assert origins[j] == pytest.approx(T_map_laser.translation)
        bearing = T_map_laser.theta + angles[j]
        assert directions[j] == pytest.approx([np.cos(bearing), np.sin(bearing)])


def test_a_leg_stops_the_beams_that_meet_it_when_they_fire():
    directions = np.tile([1.0, 0.0], (4, 1))
    ranges = np.array([3.0, 3.0, 1.0, 3.0])
    legs = np.array([[[2.0, 0.0]], [[2.0, 0.3]]])  # it leaves the way between the rows
    stop_at_legs(np.zeros((4, 2)), directions, ranges, legs, np.array([0.1]), 0.25)
    assert ranges == pytest.approx([1.9, 2.0 - np.sqrt(0.1**2 - 0.075**2), 1.0, 3.0])
