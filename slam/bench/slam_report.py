"""``hopslam bench slam``: errors and costs on recorded logs, compared with raw odometry and other systems.

PEERS are the best results of LaMa, Karto, GMapping and others, built from their own sources and run on these logs. The
relations between poses were published by Kuemmerle et al. 2009. The reference trajectories are GMapping's.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from slam.bench.log_runs import LOGS, LogRun, centre_poses, odometry_with_doubled_noise, run_log
from slam.bench.map_shape import crispness, crispness_beams, shape_table
from slam.bench.stopwatch import milliseconds
from slam.bench.worker_pool import run_in_workers
from slam.config import SlamConfig
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.files.tum import read_tum
from slam.pose import FloatArray, relative_poses, wrap_angle
from slam.run.scoring.pose_errors import absolute_error, poses_at, read_relations, relation_errors, relative_error

DOUBLED_NOISE: Final = "corridor, noise x 2"
PEERS: Final = {
    "corridor_synthetic": "ATE 0.077 (Karto), heading 0.10 (LaMa, 30 particles), extent 1.005 (Karto)",
    "fr079": "relations 0.047 m, 1.13 deg (LaMa)",
    "mines1": "crispness 43.8 on another log of the same series (small_gicp)",
}


def slam_tables(names: Sequence[str], folder: Path, config: SlamConfig, console: Terminal) -> list[ResultTable]:
    """Run the logs of these names in the folder, or all; missing ones are skipped."""
    asked = list(names) or list(LOGS)
    paths = {name: folder / LOGS.get(name, name) for name in asked}
    for name, path in paths.items():
        if not path.is_file():
            console.print(f"{name}: no {path}; skipped")
    jobs: list[tuple[str, Path, FloatArray | None]] = [(n, p, None) for n, p in paths.items() if p.is_file()]
    reference = folder / "corridor_synthetic.gt.tum"
    if reference.is_file() and any(name == "corridor_synthetic" for name, *_ in jobs):
        path, truth = paths["corridor_synthetic"], read_tum(reference)[1]
        jobs += [(f"{DOUBLED_NOISE}, {s}", path, odometry_with_doubled_noise(truth, s)) for s in (0, 1, 2)]
    runs = run_in_workers(run_log, [(path, config, odometry) for _, path, odometry in jobs], "logs", console)
    if not runs:
        return []
    found = [(name, run) for (name, *_), run in zip(jobs, runs, strict=True)]
    errors = _error_table([_error_row(name, run, folder) for name, run in found])
    return [errors, shape_table(found), _cost_table(found)]


def _error_table(rows: list[tuple[str, ...]]) -> ResultTable:
    columns = (
        "log", "ATE\nm", "odometry\nm", "RPE 10 m\nm", "odometry\nm", "relations\nm, deg", "extent",
        "end\nm, deg", "crisp",
    )  # fmt: skip
    peers = "; ".join(f"{name}: {text}" for name, text in PEERS.items())
    notes = (
        "Poses as estimated at each scan. End: difference of the last pose from the reference, or from the start "
        "without a reference. Crisp: occupied 5 cm cells per 1000 points, deskewed / not deskewed. Best of eight other "
        f"systems: {peers}."
    )
    return ResultTable("Errors", columns, rows, notes)


def _error_row(name: str, run: LogRun, folder: Path) -> tuple[str, ...]:
    reference, relations = folder / f"{run.name}.gt.tum", folder / f"{run.name}.relations.gz"
    cells = dict.fromkeys(("ate", "ate_odometry", "rpe", "rpe_odometry", "relations", "extent", "end"), "")
    stamps, end = run.log.stamps, relative_poses(run.poses[0], run.poses[-1:])[0]
    if reference.is_file():
        times, truth = read_tum(reference)
        for key, poses in (("", run.poses), ("_odometry", run.odometry)):
            at = poses_at(times, stamps, poses)
            cells["ate" + key] = f"{absolute_error(at.poses[at.known], truth[at.known]):.3f}"
            cells["rpe" + key] = f"{relative_error(at.poses[at.known], truth[at.known]):.3f}"
        estimate = poses_at(times, stamps, run.poses).poses
        cells["extent"] = f"{_extent(estimate) / _extent(truth):.4f}"
        end = relative_poses(truth[0], truth[-1:])[0] - relative_poses(estimate[0], estimate[-1:])[0]
    if relations.is_file():
        known = read_relations(relations)
        cells["relations"] = " / ".join(
            f"{np.mean(found.metres):.4f}+-{np.std(found.metres):.3f}, {np.degrees(np.mean(found.radians)):.2f}"
            for found in (relation_errors(known, stamps, poses) for poses in (run.poses, centre_poses(run.poses)))
        )
    cells["end"] = f"{np.hypot(*end[:2]):.3f}, {abs(np.degrees(wrap_angle(float(end[2])))):.2f}"
    crisp = {
        crispness(run.log, run.poses, *crispness_beams(run.log), deskew)
        for deskew in {run.log.time_increment != 0.0, False}
    }
    return (name, *cells.values(), " / ".join(f"{value:.1f}" for value in sorted(crisp)))


def _extent(poses: FloatArray) -> float:
    return float(np.hypot(*(poses[:, :2] - poses[0, :2]).T).max())


def _cost_table(found: list[tuple[str, LogRun]]) -> ResultTable:
    columns = (
        "log", "scans", "ms", "p99 ms", "CPU\nms", "p99 CPU\nms", "last 10 %\nover first", "surfels", "walls", "open",
        "searched", "lost", "odometry\nonly", "inliers",
    )  # fmt: skip
    rows = []
    for name, run in found:
        tenth = max(len(run.times) // 10, 1)
        rows.append(
            (
                name, str(len(run.times)), *milliseconds(run.times), *milliseconds(run.cpu_times),
                f"{np.median(run.cpu_times[-tenth:]) / np.median(run.cpu_times[:tenth]):.2f}",
                str(int(run.map_points[-1])), str(len(run.walls)), str(run.unconstrained), str(run.searched),
                str(run.lost), str(run.odometry_only), f"{np.mean(run.inliers[1:]):.2f}",
            )
        )  # fmt: skip
    notes = (
        "Milliseconds of wall time and of the thread's processor time. Open: scans that do not constrain the pose in "
        "some direction; odometry only: scans whose match was rejected. Inliers: share of a scan's facets that agree "
        "with the map."
    )
    return ResultTable("Costs, a scan", columns, rows, notes)
