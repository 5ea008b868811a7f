"""Runs of the method on one log with and without loop closing, scan by scan in turn under the same machine load."""

from dataclasses import dataclass
from time import process_time, thread_time

import numpy as np

from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.files.logs import Log
from slam.graph.closure import ClosedRun
from slam.line_slam import Estimate, LineSlam
from slam.pose import FloatArray, stack_poses
from slam.run.warm_up import warm_up


@dataclass(frozen=True, slots=True, eq=False)
class BothWays:
    """Results with and without closed loops; poses are ``T_map_base`` at every scan, (N, 3)."""

    unclosed: FloatArray
    """Poses without closed loops."""
    live: FloatArray
    """Poses with the loops that had been closed by then."""
    final: FloatArray
    """Poses after the end, with all loops closed."""
    closed: ClosedRun
    unclosed_times: FloatArray
    """Processor time of every update without loops, seconds, (N,)."""
    live_times: FloatArray
    """Processor time of every update with loops, on its own thread, seconds, (N,)."""
    live_total: float
    """Processor time of all updates with loops, including the search on other threads."""
    finish_time: float
    """Processor time after the last scan."""
    unclosed_walls: FloatArray
    """Segments of the map without closed loops, (M, 2, 2)."""
    final_walls: FloatArray
    """Segments of the closed map, (M, 2, 2)."""


def without_loops(config: SlamConfig) -> SlamConfig:
    """Return the same settings with ``loops: never``."""
    return config.model_copy(update={"loops": "never"})


def local_poses(estimates: list[Estimate]) -> FloatArray:
    """Return ``T_local_base`` (N, 3): poses by odometry and matching, which closed loops do not change."""
    return stack_poses(estimate.T_map_local.inverse() @ estimate.T_map_base for estimate in estimates)


def run_both_ways(log: Log, config: SlamConfig) -> BothWays:
    """Run the method on every scan of a log, without loops and with them."""
    for settings in (config, without_loops(config)):
        warm_up(Terminal(quiet=True), settings)
    slams = [LineSlam(settings, log.T_base_laser) for settings in (without_loops(config), config)]
    estimates: tuple[list[Estimate], list[Estimate]] = [], []
    times = np.empty((2, len(log)))
    began = process_time()
    for index in range(len(log)):
        scan, odometry = log.scan(index), log.odometry(index)
        for way in (0, 1) if index % 2 else (1, 0):
            began_update = thread_time()
            estimates[way].append(slams[way].update(scan, odometry))
            times[way, index] = thread_time() - began_update
    live_total = process_time() - began - float(times[0].sum())
    assert slams[1].loops is not None
    searched = slams[1].loops.size.seconds
    began = process_time()
    closed = slams[1].finish()
    assert closed is not None
    live_total += searched
    finish_time = process_time() - began + closed.size.seconds - searched
    unclosed, live = (stack_poses(row.T_map_base for row in rows) for rows in estimates)
    return BothWays(
        unclosed, live, closed.trajectory(local_poses(estimates[1])), closed, times[0], times[1],
        live_total, finish_time, slams[0].lines.ends, closed.map.ends,
    )  # fmt: skip
