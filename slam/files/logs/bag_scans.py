"""Scans in the messages of a bag, for lidars that turn either way and may hang upside down."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.files.fields import BadLine, impossible
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.logs.streamed_ranges import at_places
from slam.files.ros import decoder
from slam.files.ros.decimals import decimal, decimal_ranges, exact_bearings
from slam.files.ros.messages import MULTI_ECHO, RawMessage
from slam.lidars import Lidar, ordered_bearings
from slam.limits import BEAMS
from slam.pose import FloatArray
from slam.scan import LaserScan

_LARGEST_BEARING: Final = 7.0
"""Largest bearing, radians: a full turn with some margin."""
_WHOLE_TURN: Final = 2.0 * np.pi + 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class BagScan:
    """One scan in the form of its message, without the ranges; ``line`` is the number of the message. SI units.

    Beam j points at ``angle_min + j * angle_increment`` in the frame of the lidar, where the increment may be negative,
    and was taken ``j * time_increment`` after the stamp.
    """

    line: int
    stamp: float
    received: float
    frame: str
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    beams: int
    fingerprint: int
    """Hash of the ranges."""
    time_increment: float
    scan_time: float
    turned: bool = False
    """True if its beams are in the reverse order of the message."""

    def upright(self, inverted: bool) -> tuple[BagScan, Lidar]:
        """Return the scan with its beams counter-clockwise from above, and a description of its lidar.

        ``inverted`` is True for a lidar that is mounted upside down: its bearings change their sign. If the order of
        the beams is reversed, so is their time order: the stamp is then the time of the new first beam. ``scan_time``
        of the
        description is left 0, as one scan does not show it.
        """
        sign, beams = -1.0 if inverted else 1.0, self.beams
        first, step, turned = ordered_bearings(
            sign * self.angle_min, sign * self.angle_increment, beams, exact_bearings
        )
        fan = Lidar(first, step, beams, self.range_min, self.range_max, 0.0)
        if not turned:
            return self, fan
        last = self.stamp + (beams - 1) * self.time_increment
        return replace(self, stamp=last, time_increment=-self.time_increment, turned=True), fan


def scans_of_one_lidar(scans: Sequence[BagScan], statistics: ReadStatistics) -> list[BagScan]:
    """Return the scans of the most frequent frame; others are skipped."""
    often = Counter(scan.frame for scan in scans).most_common(1)
    for scan in scans:
        if scan.frame != often[0][0]:
            statistics.skip(f"scans of another lidar, whose frame is {scan.frame}", scan.line, scan=False)
    return [scan for scan in scans if scan.frame == often[0][0]]


def parse_laser_scan(raw: RawMessage, number: int) -> BagScan:
    """Read the scan in a message; BadLine if it is truncated or has impossible values."""
    scan = decoder.decode(raw)
    _check(scan, len(scan.ranges))
    return BagScan(
        line=number,
        stamp=decoder.seconds(scan.header),
        received=1e-9 * raw.time,
        frame=decoder.frame_name(scan.header.frame_id),
        angle_min=float(scan.angle_min),
        angle_increment=float(scan.angle_increment),
        range_min=decimal(scan.range_min),
        range_max=decimal(scan.range_max),
        beams=len(scan.ranges),
        fingerprint=hash(_readings(raw, scan).tobytes()),
        time_increment=decimal(scan.time_increment),
        scan_time=decimal(scan.scan_time),
    )


def whole_scan(raw: RawMessage, scan: BagScan, inverted: bool) -> LaserScan:
    """Return the scan of a message with its ranges; ``inverted`` if the lidar is mounted upside down."""
    upright, fan = scan.upright(inverted)
    ranges = _ranges(raw)
    return LaserScan(
        upright.stamp, fan.angle_min, fan.angle_increment, fan.range_min, fan.range_max,
        ranges[::-1] if upright.turned else ranges, upright.time_increment, upright.scan_time,
    )  # fmt: skip


def ranges_of(
    raws: Iterable[tuple[int, RawMessage]], places: Iterable[int], turned: Iterable[bool]
) -> Iterator[FloatArray]:
    """Yield the ranges, metres (REP-117), of the messages at ``places``, which are indices of ``raws``.

    ``turned`` has True for each scan whose ranges are reversed.
    """
    for raw, is_turned in zip(at_places(raws, places), turned, strict=False):
        ranges = _ranges(raw)
        yield ranges[::-1] if is_turned else ranges


def _ranges(raw: RawMessage) -> FloatArray:
    scan = decoder.decode(raw)
    readings = _readings(raw, scan)
    ranges = decimal_ranges(readings)
    finite = np.isfinite(ranges)
    ranges[finite & (readings > scan.range_max)] = np.inf  # REP-117: no echo
    ranges[finite & (readings < scan.range_min)] = -np.inf  # REP-117: too close, which says nothing about free space
    ranges[ranges == 0.0] = np.nan  # many drivers write 0 for no measurement
    return ranges


def _readings(raw: RawMessage, scan: Any) -> NDArray[np.float32]:
    """Return the ranges in the message: the nearest echo of a lidar with several echoes, nan without one."""
    if raw.type != MULTI_ECHO:
        readings: NDArray[np.float32] = scan.ranges
        return readings
    return np.array([beam.echoes[0] if len(beam.echoes) else np.nan for beam in scan.ranges], np.float32)


def _check(scan: Any, beams: int) -> None:
    """Raise BadLine, with field and value, for a scan that no lidar makes."""
    if beams < 1:
        raise impossible("number of ranges", beams)
    if excess := BEAMS.excess(beams):
        raise BadLine("too many beams", excess)
    step = float(scan.angle_increment)
    for name, fits in {
        "angle_min": abs(scan.angle_min) < _LARGEST_BEARING,
        "angle_increment": step != 0.0 and (beams - 1) * abs(step) < _WHOLE_TURN,
        "range_max": scan.range_max > scan.range_min,
        "time_increment": abs(scan.time_increment) < 1.0,
    }.items():
        if not fits:
            raise impossible(name, float(getattr(scan, name)))
