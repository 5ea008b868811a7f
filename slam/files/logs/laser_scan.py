"""One ``sensor_msgs/LaserScan`` of a bag."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slam.files.fields import BadLine
from slam.files.ros.decoder import bearings, decimal, decode, frame_name, metres, seconds
from slam.files.ros.raw_message import RawMessage
from slam.pose import FloatArray


class BagFan(NamedTuple):
    """What the message says of its lidar; radians and metres."""

    angle_min: float
    angle_increment: float
    beams: int
    range_min: float
    range_max: float


@dataclass(frozen=True, slots=True, eq=False)
class BagScan:
    """One scan; ``line`` is the number of its message. Ranges in metres, as REP-117 has them; times in seconds."""

    line: int
    stamp: float
    frame: str
    fan: BagFan
    ranges: FloatArray
    time_increment: float


def parse_laser_scan(raw: RawMessage, number: int) -> BagScan:
    """The scan in a message; BadLine when it is cut or says what cannot be."""
    scan = decode(raw)
    beams, step = len(scan.ranges), scan.angle_increment
    turn = (beams - 1) * step
    possible = step > 0.0 and scan.range_max > scan.range_min and abs(scan.angle_min) < 7.0
    if beams < 1 or not possible or turn >= 2.0 * np.pi + 1e-3 or not abs(scan.time_increment) < 1.0:
        raise BadLine("impossible value")
    ranges = metres(scan.ranges)
    finite = np.isfinite(ranges)
    ranges[finite & (scan.ranges > scan.range_max)] = np.inf  # REP 117: no echo ...
    ranges[finite & (scan.ranges < scan.range_min)] = -np.inf  # ... and too close, which says nothing of free space
    reach = decimal(scan.range_min), decimal(scan.range_max)
    fan = BagFan(*bearings(scan.angle_min, step), beams, *reach)
    frame, between = frame_name(scan.header.frame_id), decimal(scan.time_increment)
    return BagScan(number, seconds(scan.header), frame, fan, ranges, between)
