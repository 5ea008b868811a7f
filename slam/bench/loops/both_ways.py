"""Runs of the method on one log with loops closed and without, scan by scan in turn: both meet the same load."""

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
    """Result of a run; poses are ``T_map_base`` at every scan, (N, 3)."""

    causal: FloatArray
    """With no loop closed ..."""
    live: FloatArray
    """... with loops that were closed until then ..."""
    final: FloatArray
    """... and after the end."""
    closed: ClosedRun
    causal_times: FloatArray
    """Processor time of every update without loops, seconds, (N,) ..."""
    live_times: FloatArray
    """... and with them, what other threads do for them left out."""
    live_total: float
    """Processor time of all updates with loops, of the search beside them too ..."""
    finish_time: float
    """... and after the last scan."""
    causal_walls: FloatArray
    """Segments of the map, (M, 2, 2) ..."""
    final_walls: FloatArray
    """... and of the closed one."""


def without_loops(config: SlamConfig) -> SlamConfig:
    """The same settings, but that loops are left open."""
    return config.model_copy(update={"loops": "never"})


def local_poses(estimates: list[Estimate]) -> FloatArray:
    """``T_local_base`` (N, 3): the poses of odometry and matching, which no closed loop moves."""
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
    causal, live = (stack_poses(row.T_map_base for row in rows) for rows in estimates)
    return BothWays(
        causal, live, closed.trajectory(local_poses(estimates[1])), closed, times[0], times[1],
        live_total, finish_time, slams[0].lines.ends, closed.map.ends,
    )  # fmt: skip
