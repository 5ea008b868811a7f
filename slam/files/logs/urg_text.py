"""The text logs of a URG-04LX on a robot with wheel encoders that came with tinySLAM (mines1): one scan a line.

Column 0 is the time in microseconds, 2 and 3 the left and right encoder counts, 24 to 705 the 682 ranges in mm.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise
from math import pi
from operator import matmul
from typing import Final

import numpy as np

from slam.files.fields import BadLine, bounded, distances, stamp
from slam.files.logs.log import Log, scan_time
from slam.files.logs.odometry_resets import join_resets, note_resets
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.logs.stamps import drop_repeats, scan_times
from slam.lidars import URG04LX
from slam.odometry import wheel_motion
from slam.pose import FloatArray, Pose2D, stack_poses

_FAN: Final = replace(URG04LX.lidar, range_max=5.6)
"""Beams begin at step 44, which is an assumption. 5.6 m is a URG-04LX's DMAX; 5 % of mines1 lie beyond 4.095 m."""
_TIME_INCREMENT: Final = 0.1 / 1024
"""Seconds: 600 turns a minute of 1024 steps."""
_T_BASE_LASER: Final = Pose2D(0.145, 0.0, 0.0)
_METRES_PER_COUNT: Final = 2.0 * pi * 0.077 / 2000
_TRACK: Final = 2.0 * 0.165
_FIRST_RANGE: Final = 24
_END: Final = _FIRST_RANGE + _FAN.beams
_COLUMNS: Final = (_END, _END + 1)
"""The recorder ends a line with one more column, 0."""
_ERROR_CODES: Final = 20
"""Readings below 20 are no millimetres: 0 is no echo, the others name errors (SCIP 2.0 specification, table 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class _Row:
    line: int
    stamp: float
    left: float
    right: float
    ranges: FloatArray


def recognises(line: bytes) -> bool:
    """True for a scan of such a log."""
    try:
        _parse(line.split(), 0)
    except BadLine:
        return False
    return True


def read(lines: Iterable[tuple[int, bytes]], statistics: ReadStatistics) -> Log:
    """The log in these numbered lines; LogError when there is not one scan."""
    rows = drop_repeats(list(_rows(lines, statistics)), statistics)
    if not rows:
        raise statistics.no_scans(f"lines of {_COLUMNS[-1]} columns")
    own, places = np.array([row.stamp for row in rows]), [row.line for row in rows]
    stamps, _ = scan_times(own, None, places, statistics)
    joined = join_resets(stamps, _dead_reckoning(rows))
    if joined.resets:
        note_resets(joined, (stamps - stamps[0]).tolist(), statistics)
    return Log(
        lidar=replace(_FAN, scan_time=scan_time(stamps)),
        T_base_laser=_T_BASE_LASER,
        stamps=stamps,
        ranges=np.stack([row.ranges for row in rows]),
        T_odom_base=joined.poses,
        time_increment=_TIME_INCREMENT,
        skipped=statistics.skipped,
        ignored=statistics.ignored,
        report=statistics.report(len(rows)),
        lost=statistics.lost,
    )


def _rows(lines: Iterable[tuple[int, bytes]], statistics: ReadStatistics) -> Iterator[_Row]:
    for number, line in lines:
        words = line.split()
        if not words or words[0].startswith(b"#"):
            continue
        try:
            yield _parse(words, number)
        except BadLine as fault:
            statistics.skip(str(fault), number, fault.detail)


def _parse(words: list[bytes], line: int) -> _Row:
    if len(words) not in _COLUMNS:
        raise BadLine("truncated" if len(words) < _END else "too long")
    left, right = bounded(words[2:4], 1e10, "left_count right_count")
    return _Row(line, stamp(words[0], unit=1e-6), left, right, _ranges(distances(words[_FIRST_RANGE:_END])))


def _ranges(readings: FloatArray) -> FloatArray:
    """Readings in millimetres as metres, +inf for no echo and nan for an erroneous reading."""
    ranges = np.where(readings < _ERROR_CODES, np.nan, readings / 1000.0)
    ranges[(readings == 0.0) | (ranges > _FAN.range_max)] = np.inf
    return ranges


def _dead_reckoning(rows: list[_Row]) -> FloatArray:
    """``T_odom_base`` at every row from the encoder counts, shape (N, 3)."""
    motions = (
        wheel_motion(_METRES_PER_COUNT * (b.left - a.left), _METRES_PER_COUNT * (b.right - a.right), _TRACK)
        for a, b in pairwise(rows)
    )
    return stack_poses(accumulate(motions, matmul, initial=Pose2D()))
