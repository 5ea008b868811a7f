"""Correction of a scan for the motion of the robot while its beams were taken."""

from dataclasses import replace

import numpy as np

from slam.compiled import compiled
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scan import BEARING, COS, SIN, LaserScan


def deskewed(scan: LaserScan, twist: Twist2D, T_base_laser: Pose2D) -> LaserScan:
    """Return the scan as if all its beams had been taken at its stamp; the base moves with ``twist``.

    Beam j was taken ``j * time_increment`` after the stamp; its end point is transformed along the arc to the frame of
    the sensor at the stamp, where it has a bearing of its own. Beams without echo keep their reading and are only
    rotated. A scan without ``time_increment``, or taken at rest, is returned unchanged.
    """
    if scan.time_increment == 0.0 or twist == Twist2D():
        return scan
    step = T_base_laser.inverse() @ twist.motion(scan.time_increment) @ T_base_laser
    ranges, beam_fan = _from_first_beam(scan.ranges, scan.fan, step.x, step.y, step.theta)
    return replace(scan, ranges=ranges, time_increment=0.0, beam_fan=beam_fan)


@compiled
def _from_first_beam(
    ranges: FloatArray, fan: FloatArray, step_x: float, step_y: float, step_theta: float
) -> tuple[FloatArray, FloatArray]:
    """Return ranges (N,) and fan (3, N) from the sensor's pose at the first beam; it moves by one step per beam."""
    new_ranges, new_fan = ranges.copy(), np.empty_like(fan)
    step_c, step_s = np.cos(step_theta), np.sin(step_theta)
    x, y, c, s = 0.0, 0.0, 1.0, 0.0  # pose of the sensor at beam j
    for j in range(len(ranges)):
        ux, uy = c * fan[COS, j] - s * fan[SIN, j], s * fan[COS, j] + c * fan[SIN, j]
        new_fan[BEARING, j], new_fan[COS, j], new_fan[SIN, j] = fan[BEARING, j] + step_theta * j, ux, uy
        if np.isfinite(ranges[j]):
            px, py = x + ranges[j] * ux, y + ranges[j] * uy
            r = np.sqrt(px * px + py * py)
            new_ranges[j], new_fan[COS, j], new_fan[SIN, j] = r, px / r, py / r
            new_fan[BEARING, j] += np.arctan2(ux * py - uy * px, ux * px + uy * py)
        x, y = x + c * step_x - s * step_y, y + s * step_x + c * step_y
        c, s = c * step_c - s * step_s, s * step_c + c * step_s
    return new_ranges, new_fan
