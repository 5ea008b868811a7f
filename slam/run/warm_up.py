"""The hot loops, compiled before the clock of a run starts."""

from __future__ import annotations

from time import perf_counter

import numpy as np
from rich.console import Console

from slam.config import SlamConfig
from slam.lidars import TABLE1
from slam.line_slam import LineSlam
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.scan import LaserScan


def warm_up(console: Console, config: SlamConfig) -> None:
    """Make sure the hot loops of these settings are compiled; the first time on a machine takes some seconds, and says
    so."""
    began = perf_counter()
    with console.status("loading the hot loops (the first run on a machine compiles them)"):
        _two_updates(config.model_copy(update={"update_distance": 0.0}))
    taken = perf_counter() - began
    if taken > 2.0:
        console.print(f"compiled the hot loops in {taken:.0f} s; they are kept for the next run")


def _two_updates(config: SlamConfig) -> None:
    """The first scan makes a map, the second is matched to it: every hot loop has run."""
    lidar = TABLE1.lidar
    walls = np.minimum(1.0 / np.maximum(np.abs(np.cos(lidar.angles)), 1e-3), 3.0)
    slam = LineSlam(config, Pose2D())
    for stamp in (0.0, lidar.scan_time):
        scan = LaserScan(stamp, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max, walls)
        slam.update(scan, Odometry(stamp, Pose2D()))
