"""Time of line extraction compared with a lower bound: one pass that fills prefix sums."""

import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

import numpy as np

from slam.bench.scenes import HELD_OUT_SEEDS, scenes
from slam.bench.stopwatch import median_seconds, microseconds, seconds
from slam.config import ChiSquareConfig, HoppingConfig
from slam.console.result_table import ResultTable
from slam.lines.beam_sums import SUMS, prefix_sums
from slam.lines.chi_square import segments_by_chi_square, segments_of_scans
from slam.lines.hopping import segments_by_hopping
from slam.lines.learnt_noise import LearntNoise
from slam.lines.range_noise import noise_of_sensor
from slam.pose import FloatArray
from slam.scan import LaserScan

BATCH_SCANS: Final = 2000
ROUNDS: Final = 7


def time_table(seeds: int) -> ResultTable:
    """Time each function with a call for each scan; then ours with many scans in a call, on one thread and on all."""
    found = [scene.scan for scene in scenes(HELD_OUT_SEEDS[:seeds], "spec/3")]
    points = [scan.points() for scan in found]
    ours, paper, noise = ChiSquareConfig(), HoppingConfig(psi=0, L_Th=8), noise_of_sensor("urg04lx", 3.0)
    learnt = LearntNoise.start(ours)
    calls: dict[str, Sequence[Callable[[], object]]] = {
        "prefix sums alone": [_sums_of(scan) for scan in found],
        "paper mode, psi = 0": [partial(segments_by_hopping, p, paper) for p in points],
        "ours": [partial(segments_by_chi_square, scan, ours, noise) for scan in found],
        "noise, learnt": [partial(learnt.observe, scan) for scan in found],
    }
    times = _times(calls)
    least = float(np.median(times["prefix sums alone"]))
    rows = [(name, *microseconds(taken, least, digits=1)) for name, taken in times.items()]
    many = (found * (BATCH_SCANS // len(found) + 1))[:BATCH_SCANS]
    threads = os.cpu_count() or 1
    one, every = (median_seconds(partial(segments_of_scans, many, ours, noise, n), 2 * ROUNDS) for n in (1, threads))
    notes = (
        f"One call from Python, 682 beams, spec/3, without making the arrays; {ROUNDS} rounds in one process. "
        f"{BATCH_SCANS} scans at once: {1e6 * one / BATCH_SCANS:.1f} us a scan on one thread, "
        f"{1e6 * every / BATCH_SCANS:.1f} on {threads}: {one / every:.2f} times as fast."
    )
    return ResultTable("Time of one scan", ("", "median\nus", "p99\nus", "x\nsums"), rows, notes)


def _sums_of(scan: LaserScan) -> Callable[[], object]:
    N, fan = len(scan.ranges), scan.fan
    sums, beam, after_gap = np.empty((N + 1, SUMS)), np.empty(N, np.int64), np.empty(N + 1, np.bool_)
    reach, noise = (scan.range_min, scan.range_max), noise_of_sensor("urg04lx", 3.0)
    return lambda: prefix_sums(scan.ranges, fan, reach, noise, sums, beam, after_gap)


def _times(calls: dict[str, Sequence[Callable[[], object]]]) -> dict[str, FloatArray]:
    """Return the seconds of every call; the functions take turns, so that other load affects all of them alike."""
    for ready in calls.values():
        ready[0]()
    taken: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, ready in calls.items():
            taken[name] += [seconds(call) for call in ready]
    return {name: np.array(values) for name, values in taken.items()}
