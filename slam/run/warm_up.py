"""Compiles the hot loops before the clock of a run starts."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from time import perf_counter
from typing import Final

from slam.compiled import is_cold
from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.graph.submap_mapper import SubmapMapper
from slam.lidars import TABLE1
from slam.line_localizer import LineLocalizer
from slam.line_slam import LineSlam
from slam.lines.wall_runs import wall_runs
from slam.matching.surfel_mapper import SurfelMapper
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.run.loops_warm_up import close_loops, compiling_beside, corridor_ranges
from slam.scan import LaserScan

_PLACES: Final = (*(0.06 * k for k in range(8)), 2.0)
"""Positions along the path, metres; odometry reports a jump before the last one."""
_BEAM_TIME: Final = 1e-4
"""Seconds."""


def warm_up(console: Terminal, config: SlamConfig, search: bool = False) -> None:
    """Compile the hot loops of these settings, if necessary.

    ``search`` includes those of the search in a saved map. The first time on a machine takes a while, with a message.
    """
    with warming_up(console, config, search, wait=True):
        pass


@contextmanager
def warming_up(console: Terminal, config: SlamConfig, search: bool = False, wait: bool = False) -> Iterator[None]:
    """Compile the hot loops of every scan before the block runs, and those of loop closing while it runs.

    With ``wait`` all are compiled before the block. If the block needs a function that is not compiled yet, it waits
    for it.
    """
    began = perf_counter()
    with ExitStack() as beside:
        with console.waiting("loading the hot loops (the first run on a machine compiles them)"):
            slam = LineSlam(config.model_copy(update={"update_distance": 0.0}), Pose2D())
            closes_loops = isinstance(slam.mapper, SubmapMapper)
            finish = beside.enter_context(compiling_beside()) if closes_loops else None
            _run(slam)
            if search and isinstance(slam.mapper, SurfelMapper):
                _run(LineLocalizer(config, Pose2D(), slam.mapper.map))
            if finish is not None and wait:
                close_loops(config, keys=1)  # the part that the other process compiles last
                finish()
                close_loops(config)
        taken = perf_counter() - began
        if taken > 2.0:
            of, rest = ("", "") if wait else (" of a scan", ", and compiles those of loop closing beside the run")
            console.print(f"compiled the hot loops{of} in {taken:.0f} s{rest}; they are kept for the next run")
        yield


def is_first_run(config: SlamConfig) -> bool:
    """Return True before the first run with SLAM in this project's own mode on this machine."""
    return config.mode == "hopslam" and is_cold(wall_runs)


def _run(slam: LineSlam | LineLocalizer) -> None:
    """Drive along a corridor, until the building has main directions from enough wall, and then jump.

    This runs every hot loop, including those that need motion, long walls or a doubtful pose.
    """
    lidar = TABLE1.lidar
    walls = corridor_ranges()
    for index, x in enumerate(_PLACES):
        stamp = index * lidar.scan_time
        scan = LaserScan(
            stamp, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max, walls, _BEAM_TIME
        )
        slam.update(scan, Odometry(stamp, Pose2D(x), Twist2D(0.6, 1e-6)))
