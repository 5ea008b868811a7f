"""Runs of the method on recorded logs."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from time import thread_time
from typing import Final

import numpy as np

from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.files.logs import Log, read_log
from slam.line_slam import LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, compose_poses, stack_poses
from slam.run.warm_up import warm_up

LOGS: Final = {
    name: f"{name}.dat.gz" if name == "mines1" else f"{name}.log.gz"
    for name in ("corridor_synthetic", "fr079", "aces", "fr101", "belgioioso", "duke_loop5", "wean1", "wean3", "mines1")
}
CENTRE_AHEAD: Final = 0.04
"""Distance of the robot's centre ahead of the laser in fr079, metres. The log ignores it, and gives the laser the pose
of the centre; the reference has relative poses of the true centre."""


@dataclass(frozen=True, slots=True, eq=False)
class LogRun:
    """Result of the method on one log."""

    name: str
    log: Log
    poses: FloatArray
    """``T_map_base`` at every scan, as estimated then, (N, 3)."""
    odometry: FloatArray
    """Odometry that the method was given, (N, 3)."""
    times: FloatArray
    """Wall time of every update, seconds, (N,)."""
    cpu_times: FloatArray
    """Processor time of its thread, seconds, (N,), which other load does not affect."""
    inliers: FloatArray
    """Share of every scan that agreed with the map, (N,)."""
    unconstrained: int
    """Number of scans that did not constrain the pose in every direction."""
    searched: int
    """Number of scans that needed the coarse search."""
    lost: int
    """Number of scans in which the robot was lost."""
    odometry_only: int
    """Number of scans that were matched but rejected, so that their pose is odometry alone."""
    map_points: FloatArray
    """Size of the map after every scan, (N,)."""
    walls: FloatArray
    """Segments of the map at the end, (M, 2, 2)."""


def run_log(path: Path, config: SlamConfig, odometry: FloatArray | None = None) -> LogRun:
    """Run the method on every scan of a log; ``odometry`` (N, 3) replaces the recorded one."""
    return run_on(read_log(path), path.name.split(".")[0], config, odometry)


def run_on(log: Log, name: str, config: SlamConfig, odometry: FloatArray | None = None) -> LogRun:
    """Run the method on every scan of a log that is in memory."""
    warm_up(Terminal(quiet=True), config)
    given = log.T_odom_base if odometry is None else odometry
    slam, rows, cpu_times = LineSlam(config, log.T_base_laser), [], []
    for index in range(len(log)):
        recorded = log.odometry(index)
        wheels = Odometry(recorded.stamp, Pose2D.from_array(given[index]), recorded.twist)
        scan, began = log.scan(index), thread_time()
        rows.append(slam.update(scan, wheels))
        cpu_times.append(thread_time() - began)
    matches = [row.match for row in rows]
    return LogRun(
        name=name,
        log=log,
        poses=stack_poses(row.T_map_base for row in rows),
        odometry=given,
        times=np.array([row.total_time for row in rows]),
        cpu_times=np.array(cpu_times),
        inliers=np.array([match.inliers / max(match.points, 1) for match in matches]),
        unconstrained=sum(match.unconstrained is not None and len(match.unconstrained) > 0 for match in matches),
        searched=sum(match.searched for match in matches),
        lost=sum(match.lost for match in matches),
        odometry_only=sum(match.odometry_only for match in matches),
        map_points=np.array([row.map_points for row in rows]),
        walls=slam.lines.ends,
    )


def centre_poses(poses: FloatArray) -> FloatArray:
    """Return the poses (N, 3) of the robot's centre."""
    return compose_poses(poses, np.broadcast_to([CENTRE_AHEAD, 0.0, 0.0], poses.shape))


def odometry_with_doubled_noise(truth: FloatArray, seed: int) -> FloatArray:
    """Make wheel odometry (N, 3) of these poses (N, 3) with twice the errors of corridor_synthetic.

    Distances are scaled by 1.04; the heading is a random walk of 3 deg per square root of a metre, and turns are 4 %
    off.
    """
    motions = [a.between(b) for a, b in pairwise(map(Pose2D.from_array, truth))]
    random, pose = np.random.default_rng(seed), Pose2D()
    poses = [pose]
    for motion in motions:
        distance = motion.distance(Pose2D())
        turn = (
            motion.theta * (1.0 + 0.04 * random.choice([-1.0, 1.0])) + np.radians(3.0) * distance**0.5 * random.normal()
        )
        pose = pose @ Pose2D(1.04 * motion.x, 1.04 * motion.y, float(turn))
        poses.append(pose)
    return stack_poses(poses)
