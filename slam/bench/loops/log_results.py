"""A log run with loops and without, and all that is told of it."""

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
"""Metres of white noise by which one log becomes many."""


class TrajectoryScore(NamedTuple):
    """Scores of one trajectory; nan where there is nothing to compare with."""

    relations: float
    """Mean error of the relations, metres ..."""
    centre: float
    """... and of the robot's centre ..."""
    ate: float
    """... against the reference."""
    gap: LoopGap | None
    """Gap between the end of the log and its start."""
    crisp: float
    """Occupied cells for every 1000 points."""


class LogResult(NamedTuple):
    """Scores of a run without loops and with."""

    name: str
    scans: int
    causal: TrajectoryScore
    live: TrajectoryScore
    final: TrajectoryScore
    causal_off_axes: float
    """Root mean square of the directions of the long walls about the building's axes, radians ..."""
    final_off_axes: float
    """... and in the closed map."""
    loops: LoopCounts | None
    """None without a reference ..."""
    places: PlaceHits | None
    """... and places from walls alone too."""
    causal_times: FloatArray
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
    causal, live, final = (score_trajectory(path, log, poses) for poses in (found.causal, found.live, found.final))
    return LogResult(
        name,
        len(log),
        causal,
        live,
        final,
        rms_off_axes(found.causal_walls),
        rms_off_axes(found.final_walls),
        None if reference is None else count_loops(found.closed, reference),
        None if reference is None else place_hits(found.closed, reference),
        found.causal_times,
        found.live_times,
        found.live_total,
        found.finish_time,
    )


def reference_at_scans(path: Path, log: Log, found: BothWays) -> InterpolatedPoses | None:
    """The reference at every scan, carried between its poses by what the matcher found; None where there is none."""
    reference = _beside(path, "gt.tum")
    if not reference.is_file():
        return None
    return carried_poses(log.stamps, Trajectory(*read_tum(reference)), Trajectory(log.stamps, found.final))


def score_trajectory(path: Path, log: Log, poses: FloatArray) -> TrajectoryScore:
    """Score the poses (N, 3) at the scans of a log by what lies beside it, and by what its scans draw there."""
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
