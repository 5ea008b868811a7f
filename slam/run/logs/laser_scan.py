"""One ``sensor_msgs/LaserScan`` as ROS 1 puts it on the wire."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slam.pose import FloatArray
from slam.run.logs.fields import BadLine


class BagFan(NamedTuple):
    """What the message says of its lidar; radians, metres, seconds."""

    angle_min: float
    angle_increment: float
    beams: int
    range_min: float
    range_max: float
    time_increment: float


@dataclass(frozen=True, slots=True, eq=False)
class BagScan:
    """One scan; ``line`` is the number of its message. Ranges in metres, as REP-117 has them."""

    line: int
    stamp: float
    fan: BagFan
    ranges: FloatArray


def parse_laser_scan(data: bytes, number: int) -> BagScan:
    """``header, angle_min, angle_max, angle_increment, time_increment, scan_time, range_min, range_max, ranges``; the
    intensities after them are not read. BadLine when it is cut or says what cannot be."""
    try:
        _, seconds, nanoseconds, length = struct.unpack_from("<4I", data)
        at = 16 + length
        angle_min, _, step, time_increment, _, range_min, range_max, beams = struct.unpack_from("<7fI", data, at)
        ranges = np.frombuffer(data, "<f4", beams, at + 32).astype(np.float64)
    except (struct.error, ValueError):
        raise BadLine("truncated") from None
    turn = (beams - 1) * step
    if beams < 1 or not (step > 0.0 and range_max > range_min and abs(angle_min) < 7.0 and turn < 2.0 * np.pi + 1e-3):
        raise BadLine("impossible value")
    outside = np.isfinite(ranges) & ((ranges < range_min) | (ranges > range_max))
    ranges[outside] = np.inf
    fan = BagFan(angle_min, step, beams, range_min, range_max, time_increment)
    return BagScan(number, round(seconds + 1e-9 * nanoseconds, 6), fan, ranges)
