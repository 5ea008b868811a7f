"""The method on scans of 80 beams, short enough to run uncompiled too: see ``make coverage``."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from slam.config import ChiSquareConfig, SlamConfig
from slam.graph.back_end import BackEnd
from slam.graph.closure import ClosedRun
from slam.graph.constellation import Constellation
from slam.graph.submap_mapper import SubmapMapper
from slam.graph.wall_places import propose_places
from slam.line_localizer import LineLocalizer
from slam.line_slam import LineSlam
from slam.lines.chi_square import segments_by_chi_square, segments_of_scans
from slam.lines.learnt_noise import ASSUMED
from slam.matching.coarse_search import PLACE_X
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.scan import LaserScan
from tests.ring import around, ranges_from

BEARINGS = np.arange(-2.0, 2.0, 0.05)


def scan_at(pose: Pose2D, number: int, reach: float = 8.0) -> LaserScan:
    """Return a scan from a pose in the ring, with noise of 1 cm."""
    ranges = ranges_from(pose, BEARINGS) + np.random.default_rng(number).normal(0.0, 0.01, len(BEARINGS))
    ranges[ranges > reach] = np.inf
    return LaserScan(0.1 * number, float(BEARINGS[0]), 0.05, 0.05, reach, ranges)


@cache
def lap() -> tuple[FloatArray, FloatArray, ClosedRun]:
    """Drive one and a half laps on wheels that turn too far; return truth and local poses, (N, 3), and the closed run.

    The back end runs in this process, between the scans.
    """
    path, wheels = around(1.5)[::2], Pose2D()
    slam = LineSlam(SlamConfig(), Pose2D(), path[0])
    slam.loops = None
    assert isinstance(slam.mapper, SubmapMapper)
    back_end, local = BackEnd(slam.mapper.config, slam.mapper.map.config), []
    for k, pose in enumerate(path):
        motion = path[max(k - 1, 0)].between(pose)
        wheels = wheels @ Pose2D(1.002 * motion.x, motion.y, motion.theta + 0.004 * motion.x)
        slam.update(scan_at(pose, k), Odometry(0.1 * k, wheels))
        local.append(slam.T_local_base)
        if slam.mapper.key is not None:
            back_end.take(replace(slam.mapper.key, index=k))
    return stack_poses(path), stack_poses(local), back_end.finish(np.zeros(3))


def test_a_lap_of_small_fans_is_closed() -> None:
    truth, local, closed = lap()
    assert (closed.weights > 0.5).sum() >= 1
    off = (closed.trajectory(local) - truth)[:, :2]
    assert np.sqrt(np.mean(np.sum(off**2, axis=1))) < 0.12
    assert len(closed.map.ends) >= 10
    assert (np.linalg.eigvalsh(closed.covariances[1:]) > 0.0).all()  # the first pose is given


def test_a_place_is_found_in_the_map_of_small_fans() -> None:
    truth, local, closed = lap()
    localizer, known = LineLocalizer(SlamConfig(), Pose2D(), closed.map), closed.trajectory(local)
    for k in range(40, 60):
        pose = Pose2D.from_array(truth[k])
        estimate = localizer.update(scan_at(pose, k), Odometry(0.1 * k, pose))
    assert estimate.T_map_base.distance(Pose2D.from_array(known[k])) < 0.05


@pytest.mark.parametrize("settings", [
    {}, {"lines": {"kernel": "svd_full"}}, {"lines": {"kernel": "svd"}, "matching": {"average": "weighted"}},
])  # fmt: skip
def test_paper_mode_follows_small_fans(settings: dict[str, Any]) -> None:
    path = around(0.25)[:8]
    slam = LineSlam(
        SlamConfig.model_validate({"mode": "paper", "matching": {"gamma_M": 0.3}} | settings), Pose2D(), path[0]
    )
    for k, pose in enumerate(path):
        estimate = slam.update(scan_at(pose, k), Odometry(0.1 * k, pose))
    assert estimate.T_map_base.distance(path[-1]) < 0.2


def test_a_room_is_found_by_its_walls_alone() -> None:
    corners = np.array([[-3, -2], [4, -2], [4, 1], [1, 1], [1, 4], [-3, 4]], float)
    walls, T = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), Pose2D(1.0, -0.5, 0.7)
    found = propose_places(Constellation.of(walls), Constellation.of(T.transform(walls)))
    off = T.between(Pose2D.from_array(found[0, PLACE_X:]))
    assert off.distance(Pose2D()) < 0.05
    assert abs(off.theta) < 0.02


def test_a_person_walking_ahead_does_not_shift_the_pose() -> None:
    path = around(0.25)[:12]
    slam = LineSlam(SlamConfig(), Pose2D(), path[0])
    for k, pose in enumerate(path):
        scan = scan_at(pose, k)
        scan.ranges[38:42] = 1.2 + 0.02 * k
        estimate = slam.update(scan, Odometry(0.1 * k, pose))
    assert estimate.T_map_base.distance(path[-1]) < 0.05


def test_a_batch_of_scans_gives_the_lines_of_each() -> None:
    scans, config = [scan_at(pose, k) for k, pose in enumerate(around(0.25)[:3])], ChiSquareConfig()
    together, begins = segments_of_scans(scans, config, ASSUMED, threads=1)
    for k, scan in enumerate(scans):
        own = together.rho[begins[k] : begins[k + 1]]
        np.testing.assert_array_equal(own, segments_by_chi_square(scan, config, ASSUMED).rho)
