"""The hot loops, compiled before the clock of a run starts."""

from __future__ import annotations

from time import perf_counter

import numpy as np
from rich.console import Console

from slam.config import SlamConfig
from slam.lidars import TABLE1
from slam.line_localizer import LineLocalizer
from slam.line_slam import LineSlam
from slam.matching.surfel_mapper import SurfelMapper
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.scan import LaserScan


def warm_up(console: Console, config: SlamConfig, search: bool = False) -> None:
    """Make sure the hot loops of these settings are compiled, those of the search in a saved map too where they are
    needed; the first time on a machine takes some seconds, and says so."""
    began = perf_counter()
    with console.status("loading the hot loops (the first run on a machine compiles them)"):
        slam = _two_updates(config.model_copy(update={"update_distance": 0.0}))
        if search and isinstance(slam.mapper, SurfelMapper):
            _two_updates_of(LineLocalizer(config, Pose2D(), slam.mapper.map))
    taken = perf_counter() - began
    if taken > 2.0:
        console.print(f"compiled the hot loops in {taken:.0f} s; they are kept for the next run")


def _two_updates(config: SlamConfig) -> LineSlam:
    """The first scan makes a map, the second is matched to it: every hot loop has run."""
    slam = LineSlam(config, Pose2D())
    _two_updates_of(slam)
    return slam


def _two_updates_of(slam: LineSlam | LineLocalizer) -> None:
    lidar = TABLE1.lidar
    walls = np.minimum(1.0 / np.maximum(np.abs(np.cos(lidar.angles)), 1e-3), 3.0)
    for stamp in (0.0, lidar.scan_time):
        scan = LaserScan(stamp, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max, walls)
        slam.update(scan, Odometry(stamp, Pose2D()))
