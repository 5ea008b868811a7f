"""Run a log with loops and without, and score both."""

from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from slam.bench.log_runs import centre_poses
from slam.bench.loops.both_ways import BothWays, run_both_ways
from slam.bench.loops.loop_errors import LoopCounts, count_loops
from slam.bench.loops.place_hits import PlaceHits, place_hits
from slam.bench.map_shape import LoopGap, crispness, crispness_beams, gap_of_loop, rms_off_axes
from slam.config import SlamConfig
from slam.files.logs import Log, read_log
from slam.files.tum import read_tum
from slam.pose import FloatArray
from slam.run.scoring.pose_errors import (
    InterpolatedPoses,
    Trajectory,
    absolute_error,
    carried_poses,
    poses_at,
    read_relations,
    relation_errors,
)

RANGE_NOISE: Final = 0.002
"""Standard deviation, metres, of the noise on the ranges that makes many logs from one."""


class TrajectoryScore(NamedTuple):
    """Scores of one trajectory; nan where there is nothing to compare with."""

    relations: float
    """Mean error of the relations, metres."""
    centre: float
    """Mean error of the relations for the robot's centre, metres."""
    ate: float
    """Absolute trajectory error against the reference, metres."""
    gap: LoopGap | None
    """Gap between the end of the log and its start."""
    crisp: float
    """Occupied cells per 1000 points."""


class LogResult(NamedTuple):
    """Scores of a run without loops and with."""

    name: str
    scans: int
    unclosed: TrajectoryScore
    live: TrajectoryScore
    final: TrajectoryScore
    unclosed_off_axes: float
    """RMS angle of the long walls from the building's main axes, radians, without closed loops."""
    final_off_axes: float
    """The same angle in the closed map, radians."""
    loops: LoopCounts | None
    """Counts of the loops; None without a reference."""
    places: PlaceHits | None
    """Ranks of the places that walls alone propose; None without a reference."""
    unclosed_times: FloatArray
    live_times: FloatArray
    live_total: float
    finish_time: float


def run_log_both_ways(path: Path, config: SlamConfig, seed: int = 0) -> LogResult:
    """Run the method on a log; a seed above 0 adds white noise to the ranges."""
    log, name = read_log(path), path.name.split(".")[0]
    if seed:
        noise = RANGE_NOISE * np.random.default_rng(seed).standard_normal(log.ranges.shape)
        log = replace(log, ranges=np.asarray(log.ranges) + noise)
    found = run_both_ways(log, config)
    reference = reference_at_scans(path, log, found)
    unclosed, live, final = (score_trajectory(path, log, poses) for poses in (found.unclosed, found.live, found.final))
    return LogResult(
        name,
        len(log),
        unclosed,
        live,
        final,
        rms_off_axes(found.unclosed_walls),
        rms_off_axes(found.final_walls),
        None if reference is None else count_loops(found.closed, reference),
        None if reference is None else place_hits(found.closed, reference),
        found.unclosed_times,
        found.live_times,
        found.live_total,
        found.finish_time,
    )


def reference_at_scans(path: Path, log: Log, found: BothWays) -> InterpolatedPoses | None:
    """Return the reference at every scan, interpolated by the matched motion; None without a reference."""
    reference = _beside(path, "gt.tum")
    if not reference.is_file():
        return None
    return carried_poses(log.stamps, Trajectory(*read_tum(reference)), Trajectory(log.stamps, found.final))


def score_trajectory(path: Path, log: Log, poses: FloatArray) -> TrajectoryScore:
    """Score the poses (N, 3) at the scans of a log by its reference files and by the map of its scans."""
    relations, centre, ate = (float("nan"),) * 3
    if (known := _beside(path, "relations.gz")).is_file():
        rows = read_relations(known)
        relations, centre = (
            float(np.mean(relation_errors(rows, log.stamps, each).metres)) for each in (poses, centre_poses(poses))
        )
    if (reference := _beside(path, "gt.tum")).is_file():
        times, truth = read_tum(reference)
        at = poses_at(times, log.stamps, poses)
        ate = absolute_error(at.poses[at.known], truth[at.known])
    crisp = crispness(log, poses, *crispness_beams(log), log.time_increment != 0.0)
    return TrajectoryScore(relations, centre, ate, gap_of_loop(path.name.split(".")[0], log, poses), crisp)


def _beside(path: Path, kind: str) -> Path:
    return path.with_name(f"{path.name.split('.')[0]}.{kind}")
