"""The method on scans of 80 beams, of which a lap is short enough to run uncompiled too: see ``make coverage``."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.graph.back_end import BackEnd
from slam.graph.closure import ClosedRun
from slam.graph.submap_mapper import SubmapMapper
from slam.line_localizer import LineLocalizer
from slam.line_slam import LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.scan import LaserScan
from tests.ring import around, ranges_from

BEARINGS = np.arange(-2.0, 2.0, 0.05)


def scan_at(pose: Pose2D, number: int, reach: float = 8.0) -> LaserScan:
    """Return a noisy scan, 1 cm, from a pose in the ring."""
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
