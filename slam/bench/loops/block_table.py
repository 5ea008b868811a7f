"""Table of the generated building of 2 km: benefit and cost of loop closing on a large scale."""

from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from slam.bench.block_log import SCANS, block_log
from slam.bench.loops.both_ways import local_poses, without_loops
from slam.bench.loops.loop_errors import LoopCounts, count_loops
from slam.bench.stopwatch import milliseconds
from slam.bench.worker_pool import run_in_workers
from slam.config import SlamConfig
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.line_slam import LineSlam
from slam.pose import FloatArray, path_lengths, stack_poses
from slam.run.scoring.pose_errors import InterpolatedPoses, absolute_error
from slam.run.warm_up import warm_up
from slam.system import peak_memory


class BlockRun(NamedTuple):
    """Result of one run in the building; seconds, metres and bytes."""

    scans: int
    path_length: float
    odometry_ate: float
    live_ate: float
    final_ate: float
    times: FloatArray
    """Wall time of every update, (N,)."""
    front_time: float
    """Wall time from the first scan to the last."""
    finish_time: float
    """Wall time after the last scan."""
    front_cpu: float
    """Processor time of the front end."""
    back_cpu: float
    """Processor time of the back end, until the closed map is complete."""
    front_memory: float
    """Peak memory of the front end, minus the memory before the first scan."""
    back_memory: float
    """Peak memory of the back end's process."""
    loops: LoopCounts | None


def block_table(seed: int, config: SlamConfig, console: Terminal, scans: int = SCANS) -> ResultTable:
    """Run the method through the building, without loops and with, each in a new process."""
    rows = []
    for way, settings in (("never", without_loops(config)), ("auto", config)):
        jobs, description = [(seed, settings, scans)], f"a building of {scans} scans, loops: {way}"
        rows += [(way, *_cells(run)) for run in run_in_workers(run_blocks, jobs, description, console, 1)]
    columns = (
        "loops", "scans", "path\nm", "odometry\nATE, m", "live\nATE, m", "final\nATE, m", "ms", "p99",
        "front end\ns", "after the\nscans, s", "front end\nCPU s", "back end\nCPU s", "front end\nMB", "back end\nMB",
        "tried", "accepted", "wrong", "believed", "wrong,\nbelieved",
    )  # fmt: skip
    notes = (
        "A lidar of 361 beams and 20 m, a scan every half metre. Milliseconds and seconds are wall time, in which the "
        "front end also waits for its back end. Memory: peak; that of the front end without the log and the code."
    )
    return ResultTable(f"A building of blocks, seed {seed}", columns, rows, notes)


def run_blocks(seed: int, config: SlamConfig, scans: int = SCANS) -> BlockRun:
    """Run the method through the building of this seed."""
    warm_up(Terminal(quiet=True), config)
    log = block_log(seed, scans)
    truth = log.T_map_base
    assert truth is not None
    slam, estimates, times = LineSlam(config, log.T_base_laser, log.start), [], []
    base_memory = peak_memory()
    began, began_cpu = perf_counter(), process_time()
    for index in range(len(log)):
        began_update = perf_counter()
        estimates.append(slam.update(log.scan(index), log.odometry(index)))
        times.append(perf_counter() - began_update)
    front, front_cpu = perf_counter() - began, process_time() - began_cpu
    began = perf_counter()
    closed = slam.finish()
    finish = perf_counter() - began
    live = stack_poses(estimate.T_map_base for estimate in estimates)
    final = live if closed is None else closed.trajectory(local_poses(estimates))
    known = InterpolatedPoses(truth, np.ones(len(truth), np.bool_))
    return BlockRun(
        len(log), float(path_lengths(truth)[-1]), absolute_error(log.T_odom_base, truth), absolute_error(live, truth),
        absolute_error(final, truth), np.array(times), front, finish, front_cpu,
        0.0 if closed is None else closed.size.seconds, peak_memory() - base_memory,
        peak_memory(of_children=True), None if closed is None else count_loops(closed, known),
    )  # fmt: skip


def _cells(run: BlockRun) -> tuple[str, ...]:
    seconds = run.front_time, run.finish_time, run.front_cpu, run.back_cpu
    loops = run.loops
    counts = (
        [""] * 5
        if loops is None
        else [str(count) for count in (loops.tried, loops.accepted, loops.wrong, loops.believed, loops.believed_wrong)]
    )
    return (
        str(run.scans), f"{run.path_length:.0f}", f"{run.odometry_ate:.1f}", f"{run.live_ate:.3f}",
        f"{run.final_ate:.3f}", *milliseconds(run.times), *(f"{value:.1f}" for value in seconds),
        f"{run.front_memory / 1e6:.0f}", f"{run.back_memory / 1e6:.0f}", *counts,
    )  # fmt: skip
