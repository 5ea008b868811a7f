"""Undo the motion of the robot while the beams of a scan were taken one after another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slam.compiled import compiled
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan


def deskewed(scan: LaserScan, twist: Twist2D, T_base_laser: Pose2D) -> LaserScan:
    """The scan as it would have been, had all beams been taken at its stamp, by a base that moves with ``twist``.

    Beam j was taken ``j * time_increment`` after the stamp; its end point is carried along the arc back to the frame of
    the sensor at the stamp, and has its own bearing from then on. Beams without echo keep their reading and are turned
    only. A scan without ``time_increment``, or at rest, is returned as it is.
    """
    if scan.time_increment == 0.0 or twist == Twist2D():
        return scan
    mount = (T_base_laser.x, T_base_laser.y, T_base_laser.theta)
    ranges, bearings = _straightened(
        scan.ranges, scan.bearings, scan.time_increment, twist.linear, twist.angular, *mount
    )
    return replace(scan, ranges=ranges, time_increment=0.0, beam_bearings=bearings)


@compiled
def _straightened(
    ranges: FloatArray, bearings: FloatArray, step: float, v: float, omega: float, mount_x: float, mount_y: float,
    mount_theta: float,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Ranges and bearings (N,) from where the sensor was at the first beam."""
    out_r, out_b = np.empty_like(ranges), np.empty_like(bearings)
    for j in range(len(ranges)):
        turn = omega * step * j
        half = 0.5 * turn
        chord = v * step * j * (np.sin(half) / half if abs(half) > 1e-8 else 1.0)
        if not np.isfinite(ranges[j]):
            out_r[j], out_b[j] = ranges[j], bearings[j] + turn
            continue
        b = bearings[j] + mount_theta + turn
        x = chord * np.cos(half) + np.cos(turn) * mount_x - np.sin(turn) * mount_y + ranges[j] * np.cos(b) - mount_x
        y = chord * np.sin(half) + np.sin(turn) * mount_x + np.cos(turn) * mount_y + ranges[j] * np.sin(b) - mount_y
        out_r[j] = np.sqrt(x * x + y * y)
        off = np.arctan2(y, x) - mount_theta - bearings[j] - turn
        out_b[j] = bearings[j] + turn + off - 2.0 * np.pi * np.floor(off / (2.0 * np.pi) + 0.5)
    return out_r, out_b
