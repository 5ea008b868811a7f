"""A long log of a walk between blocks of rooms: scans of a lidar like a SICK LMS, wheel odometry, and the truth."""

from itertools import pairwise
from math import atan2, ceil, floor, pi, sqrt
from typing import Final

import numpy as np

from slam.bench.block_plan import make_block_plan, walk
from slam.compiled import compiled
from slam.files.logs import Log
from slam.lidars import Lidar
from slam.pose import FloatArray, Pose2D, stack_poses

SCANS: Final = 3900
STEP: Final = 0.5
"""Metres from scan to scan."""
LIDAR: Final = Lidar(
    angle_min=-pi / 2.0, angle_increment=pi / 360.0, beams=361, range_min=0.05, range_max=20.0, scan_time=1.0
)
RANGE_SIGMA: Final = 0.02
"""Standard deviation of the ranges, metres."""
RESOLUTION: Final = 0.01
"""Resolution of the ranges, metres."""
DROPOUT: Final = 0.002
"""Share of the beams without echo."""
TRAVEL_SCALE: Final = 0.01
"""Odometry: standard deviation of the constant scale error of the distance."""
TRAVEL_SIGMA: Final = 0.02
"""Odometry: standard deviation of the distance after one metre, metres."""
TURN_SIGMA: Final = 0.02
"""Odometry: standard deviation of the relative error of turns."""
HEADING_SIGMA: Final = np.radians(2.0)
"""Odometry: standard deviation of the heading after one metre, radians."""
_FINE: Final = 0.05
"""Step in which the path is smoothed, metres."""
_ROUNDED: Final = 3.0
"""Length over which the path is smoothed, metres."""


def block_log(seed: int, scans: int = SCANS) -> Log:
    """Make the log of a walk through the blocks of this seed, with ``scans`` scans half a metre apart."""
    plan_random, walk_random, noise_random = (np.random.default_rng([seed, stream]) for stream in range(3))
    plan = make_block_plan(plan_random)
    truth = smooth_poses(walk(plan, 1.1 * scans * STEP + 2.0 * _ROUNDED, walk_random), STEP)[:scans]
    odometry = noisy_odometry(truth, noise_random)
    distances = cast_walls(plan.walls, truth, LIDAR.angle_min, LIDAR.angle_increment, LIDAR.beams)
    return Log(
        lidar=LIDAR,
        T_base_laser=Pose2D(),
        stamps=np.arange(0.0, scans) * LIDAR.scan_time,
        ranges=_measured(distances, noise_random),
        T_odom_base=odometry,
        time_increment=0.0,
        skipped={},
        ignored={},
        report=f"{scans} scans of a generated building, seed {seed}",
        start=Pose2D.from_array(truth[0]),
        T_map_base=truth,
    )


def smooth_poses(path: FloatArray, step: float) -> FloatArray:
    """Poses (M, 3) along a path (N, 2) with rounded corners, heading along it, about ``step`` metres apart."""
    distances = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    at = np.arange(0.0, distances[-1], _FINE)
    window = np.full(round(_ROUNDED / _FINE), _FINE / _ROUNDED)
    x, y = (np.convolve(np.interp(at, distances, column), window, "valid") for column in path.T)
    rounded = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    heading = np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))
    where = np.arange(0.0, rounded[-1], step)
    return np.column_stack([np.interp(where, rounded, column) for column in (x, y, heading)])


def noisy_odometry(truth: FloatArray, random: np.random.Generator) -> FloatArray:
    """Return wheel odometry (N, 3) of these poses (N, 3), from the origin; its errors grow with distance and turns."""
    scale = 1.0 + TRAVEL_SCALE * random.standard_normal()
    pose = Pose2D()
    poses = [pose]
    for a, b in pairwise(map(Pose2D.from_array, truth)):
        motion = a.between(b)
        metres = motion.distance(Pose2D())
        stretch = scale + TRAVEL_SIGMA * random.standard_normal() / sqrt(max(metres, 1e-9))
        turned = motion.theta * (1.0 + TURN_SIGMA * random.standard_normal())
        drift = HEADING_SIGMA * sqrt(metres) * random.standard_normal()
        pose = pose @ Pose2D(stretch * motion.x, stretch * motion.y, turned + drift)
        poses.append(pose)
    return stack_poses(poses)


@compiled
def cast_walls(
    walls: FloatArray, poses: FloatArray, angle_min: float, angle_increment: float, beams: int
) -> FloatArray:
    """Return the metres (N, beams) from each pose (N, 3) of the sensor to the first of the walls (W, 2, 2).

    Inf for none. Each wall is drawn onto the beams between the bearings of its ends, like a one-row image.
    """
    ranges = np.full((len(poses), beams), np.inf)
    for n in range(len(poses)):
        c, s = np.cos(poses[n, 2]), np.sin(poses[n, 2])
        for w in range(len(walls)):
            dx, dy = walls[w, 0, 0] - poses[n, 0], walls[w, 0, 1] - poses[n, 1]
            ax, ay = c * dx + s * dy, c * dy - s * dx
            dx, dy = walls[w, 1, 0] - poses[n, 0], walls[w, 1, 1] - poses[n, 1]
            bx, by = c * dx + s * dy, c * dy - s * dx
            cross = ax * by - ay * bx
            if cross == 0.0:
                continue  # the wall points at the sensor
            if cross < 0.0:
                ax, ay, bx, by, cross = bx, by, ax, ay, -cross
            begin = atan2(ay, ax)
            span = atan2(cross, ax * bx + ay * by)
            for turn in range(-1, 2):
                low = (begin + turn * 2.0 * pi - angle_min) / angle_increment
                for beam in range(max(ceil(low), 0), min(floor(low + span / angle_increment), beams - 1) + 1):
                    bearing = angle_min + beam * angle_increment
                    facing = np.cos(bearing) * (by - ay) - np.sin(bearing) * (bx - ax)
                    if facing > 0.0:
                        ranges[n, beam] = min(ranges[n, beam], cross / facing)
    return ranges


def _measured(distances: FloatArray, random: np.random.Generator) -> FloatArray:
    """Turn these distances into the ranges that the lidar reports."""
    ranges = distances + RANGE_SIGMA * random.standard_normal(distances.shape)
    ranges = np.round(ranges / RESOLUTION) * RESOLUTION
    lost = (ranges > LIDAR.range_max) | (random.random(distances.shape) < DROPOUT)
    return np.where(lost, np.inf, ranges)
