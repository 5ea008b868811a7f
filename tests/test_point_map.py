"""The map of points."""

from math import pi

import numpy as np
import pytest

from slam.config import PointMapConfig
from slam.lidars import TABLE1, Lidar
from slam.mapping.point_map import PointMap
from slam.pose import Pose2D

ALL = PointMapConfig(draw=1.0)


def a_map(points: list[list[float]]) -> PointMap:
    made = PointMap()
    made.add(np.array(points, dtype=float), Pose2D())
    return made


def test_points_are_kept_in_the_map_frame() -> None:
    made = PointMap()
    made.add(np.array([[1.0, 0.0]]), Pose2D(2.0, 3.0, pi / 2))
    np.testing.assert_allclose(made.points, [[2.0, 4.0]], atol=1e-12)


def test_every_point_of_every_scan_is_kept() -> None:
    made, random = PointMap(), np.random.default_rng(0)
    scans = [random.normal(0, 3, (500, 2)) for _ in range(20)]
    for scan in scans:
        made.add(scan, Pose2D())
    np.testing.assert_array_equal(made.points, np.concatenate(scans))


def test_only_visible_points_are_drawn() -> None:
    """4 m ahead at most, 6 cm at least, and nothing in the 120 degrees behind."""
    made = a_map([[3.9, 0], [4.1, 0], [0.05, 0], [-1, 0], [-0.4, 1], [-0.7, 1], [0, -2]])
    seen = made.draw_visible(Pose2D(), TABLE1.lidar, ALL, np.random.default_rng(0))
    np.testing.assert_array_equal(seen, [[3.9, 0], [-0.4, 1], [0, -2]])


def test_drawn_points_are_in_the_sensor_frame() -> None:
    """Eq. (20) undoes eq. (17)."""
    T_map_laser, scan = Pose2D(5.0, -2.0, 1.0), np.array([[1.0, 0.5], [2.0, -0.3]])
    made = PointMap()
    made.add(scan, T_map_laser)
    np.testing.assert_allclose(made.draw_visible(T_map_laser, TABLE1.lidar, ALL, np.random.default_rng(0)), scan)


def test_a_full_turn_sees_behind_the_sensor() -> None:
    made = a_map([[1, 0], [0, 1], [-1, 0.01], [0, -1]])
    for angle_min in (0.0, -pi, 1.0):
        around = Lidar(angle_min, 2 * pi / 360, 361, 0.1, 10.0, 0.1)
        assert len(made.draw_visible(Pose2D(), around, ALL, np.random.default_rng(0))) == 4


def test_the_reach_can_be_shorter_than_the_sensor_s() -> None:
    made = a_map([[1.0, 0], [3.0, 0]])
    near = made.draw_visible(Pose2D(), TABLE1.lidar, PointMapConfig(draw=1.0, reach=2.0), np.random.default_rng(0))
    np.testing.assert_array_equal(near, [[1.0, 0.0]])


def test_three_quarters_of_the_points_are_sampled() -> None:
    made = a_map([[1.0 + 1e-4 * k, 0.0] for k in range(10_000)])
    draws = [
        len(made.draw_visible(Pose2D(), TABLE1.lidar, PointMapConfig(), np.random.default_rng(k))) for k in range(5)
    ]
    assert draws == pytest.approx([7500] * 5, abs=200)  # 4.6 standard deviations
    assert len(set(draws)) > 1


def test_an_empty_map_shows_nothing() -> None:
    assert PointMap().draw_visible(Pose2D(), TABLE1.lidar, ALL, np.random.default_rng(0)).shape == (0, 2)
