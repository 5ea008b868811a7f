"""Scans in the messages of a bag, of a lidar however it turns and hangs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from slam.files.fields import BadLine, impossible
from slam.files.logs.bag_contents import Numbered
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.ros import decoder
from slam.files.ros.messages import MULTI_ECHO, RawMessage
from slam.lidars import Lidar, ordered_bearings
from slam.pose import FloatArray

_LARGEST_BEARING: Final = 7.0
"""Radians: a turn and a little more."""
_WHOLE_TURN: Final = 2.0 * np.pi + 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class BagScan:
    """One scan as its lidar gave it; ``line`` is the number of its message. Metres, radians, seconds.

    Beam j points at ``angle_min + j * angle_increment`` in the frame of the lidar, where the increment may be negative,
    and was taken ``j * time_increment`` after the stamp. Ranges are as REP-117 has them.
    """

    line: int
    stamp: float
    received: float
    frame: str
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: FloatArray
    time_increment: float

    def upright(self, inverted: bool) -> tuple[BagScan, Lidar]:
        """The scan with its beams counter-clockwise from above, of a lidar that hangs upside down or not, and its fan.

        Upside down, bearings change their sign. Where the order of the beams turns round, so does that of time: the
        stamp is that of the beam which comes first now. The fan's ``scan_time`` is that of the whole log, and 0 here.
        """
        sign, beams = -1.0 if inverted else 1.0, len(self.ranges)
        first, step, turned = ordered_bearings(
            sign * self.angle_min, sign * self.angle_increment, beams, decoder.exact_bearings
        )
        fan = Lidar(first, step, beams, self.range_min, self.range_max, 0.0)
        if not turned:
            return self, fan
        last = self.stamp + (beams - 1) * self.time_increment
        return replace(self, stamp=last, ranges=self.ranges[::-1], time_increment=-self.time_increment), fan


def parse_scans(raws: Iterable[Numbered], statistics: ReadStatistics) -> list[BagScan]:
    """The scans of one lidar in these messages: that of the most frequent frame. Others, and messages that are cut or
    say what cannot be, are skipped."""
    scans = []
    for number, raw in raws:
        try:
            scans.append(parse_laser_scan(raw, number))
        except BadLine as fault:
            statistics.skip(str(fault), number, fault.detail)
    if any(raw.type == MULTI_ECHO for _, raw in raws):
        statistics.notes.append("of each beam of its MultiEchoLaserScan messages, the first echo is read")
    often = Counter(scan.frame for scan in scans).most_common(1)
    for scan in scans:
        if scan.frame != often[0][0]:
            statistics.skip(f"scans of another lidar, whose frame is {scan.frame}", scan.line, scan=False)
    return [scan for scan in scans if scan.frame == often[0][0]]


def parse_laser_scan(raw: RawMessage, number: int) -> BagScan:
    """The scan in a message; BadLine when it is cut or says what cannot be."""
    scan = decoder.decode(raw)
    readings = _first_echoes(scan) if raw.type == MULTI_ECHO else scan.ranges
    _check(scan, len(readings))
    ranges = decoder.decimal_ranges(readings)
    finite = np.isfinite(ranges)
    ranges[finite & (readings > scan.range_max)] = np.inf  # REP 117: no echo ...
    ranges[finite & (readings < scan.range_min)] = -np.inf  # ... and too close, which says nothing of free space
    ranges[ranges == 0.0] = np.nan  # what many drivers say where they measured nothing
    return BagScan(
        line=number,
        stamp=decoder.seconds(scan.header),
        received=1e-9 * raw.time,
        frame=decoder.frame_name(scan.header.frame_id),
        angle_min=float(scan.angle_min),
        angle_increment=float(scan.angle_increment),
        range_min=decoder.decimal(scan.range_min),
        range_max=decoder.decimal(scan.range_max),
        ranges=ranges,
        time_increment=decoder.decimal(scan.time_increment),
    )


def _first_echoes(scan: Any) -> Any:
    """The nearest echo of each beam; nan where it has none."""
    return np.array([beam.echoes[0] if len(beam.echoes) else np.nan for beam in scan.ranges], np.float32)


def _check(scan: Any, beams: int) -> None:
    """BadLine, naming field and value, for a scan that no lidar gives."""
    if beams < 1:
        raise impossible("number of ranges", beams)
    step = float(scan.angle_increment)
    for name, fits in {
        "angle_min": abs(scan.angle_min) < _LARGEST_BEARING,
        "angle_increment": step != 0.0 and (beams - 1) * abs(step) < _WHOLE_TURN,
        "range_max": scan.range_max > scan.range_min,
        "time_increment": abs(scan.time_increment) < 1.0,
    }.items():
        if not fits:
            raise impossible(name, float(getattr(scan, name)))
