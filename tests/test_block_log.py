"""The long log of a generated building: rays against a plain reference, and the properties of the log."""

import numpy as np
import pytest

from slam.bench.block_log import HEADING_SIGMA, LIDAR, STEP, block_log, cast_walls, noisy_odometry, smooth_poses
from slam.bench.block_plan import make_block_plan, walk
from slam.bench.floor_plans import cast_beams, room
from slam.pose import Pose2D, compose_poses, path_lengths, relative_poses, wrap_angles

PLAN = make_block_plan(np.random.default_rng(5))


def test_drawn_walls_have_the_ranges_of_cast_beams() -> None:
    walls = np.concatenate([room(np.random.default_rng(1)), PLAN.walls[::40]])
    poses = np.array([[0.1, -0.2, 0.3], [0.0, 0.0, 3.0], [5.0, 4.0, -2.0], [-0.5, 0.1, 1.6]])
    found = cast_walls(walls, poses, -3.1, 0.02, 311)
    for pose, ranges in zip(poses, found, strict=True):
        expected, _ = cast_beams(walls, Pose2D.from_array(pose), -3.1 + 0.02 * np.arange(311))
        np.testing.assert_allclose(ranges, expected, rtol=1e-9)


def test_rays_do_not_depend_on_the_origin_of_the_world() -> None:
    pose, moved = np.array([[1.0, 2.0, 0.4]]), Pose2D(-7.0, 3.0, 2.5)
    walls = moved.transform(PLAN.walls.reshape(-1, 2)).reshape(-1, 2, 2)
    there = compose_poses(moved.as_array(), pose)
    one, other = (cast_walls(w, p, -1.5, 0.01, 301) for w, p in ((PLAN.walls, pose), (walls, there)))
    close = np.isclose(one, other, rtol=1e-6) | (np.isinf(one) & np.isinf(other))
    assert close.mean() > 0.99  # a beam may pass a corner on either side


def test_a_building_is_closed() -> None:
    """Every beam from every crossing ends at a wall."""
    crossings = np.column_stack([PLAN.crossings.reshape(-1, 2), np.zeros(PLAN.crossings[..., 0].size)])
    assert np.isfinite(cast_walls(PLAN.walls, crossings, -np.pi + 0.001, 0.05, 125)).all()


def test_a_walk_covers_all_streets_without_u_turns() -> None:
    path = walk(PLAN, 2000.0, np.random.default_rng(0))
    assert np.hypot(*np.diff(path, axis=0).T).sum() >= 2000.0
    assert not (path[2:] == path[:-2]).all(axis=1).any()
    assert len(np.unique(path, axis=0)) > 0.8 * PLAN.crossings[..., 0].size


def test_a_smoothed_path_has_even_steps_along_its_heading() -> None:
    poses = smooth_poses(np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]]), STEP)
    steps = relative_poses(poses[:-1], poses[1:])
    assert np.hypot(steps[:, 0], steps[:, 1]) == pytest.approx(STEP, abs=0.02)
    assert np.abs(steps[:, 1]).max() < 0.16
    assert np.degrees(np.abs(wrap_angles(steps[:, 2]))).max() < 30.0
    assert poses[-1, 2] == pytest.approx(np.pi, abs=1e-6)


def test_odometry_errors_grow_with_the_distance() -> None:
    straight = np.column_stack([np.arange(0.0, 200.0, STEP), np.zeros((400, 2))])
    ends = np.array([noisy_odometry(straight, np.random.default_rng(seed))[[40, -1]] for seed in range(40)])
    assert ends[:, 0, 2].std() == pytest.approx(HEADING_SIGMA * 20.0**0.5, rel=0.4)
    assert ends[:, 1, 2].std() == pytest.approx(HEADING_SIGMA * 200.0**0.5, rel=0.4)


def test_a_seed_makes_one_log_of_the_given_length() -> None:
    one, again, other = block_log(3, 50), block_log(3, 50), block_log(4, 50)
    assert np.array_equal(one.ranges, again.ranges)
    assert np.array_equal(one.T_odom_base, again.T_odom_base)
    assert not np.array_equal(one.ranges, other.ranges)
    assert one.ranges.shape == (50, LIDAR.beams)
    assert one.T_map_base is not None
    assert path_lengths(one.T_map_base)[-1] == pytest.approx(49 * STEP, abs=0.3)
    assert ((one.ranges >= 0.0) & ((one.ranges <= LIDAR.range_max) | np.isinf(one.ranges))).all()
