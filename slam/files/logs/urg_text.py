"""The text logs of a URG-04LX on a robot with wheel encoders, as in tinySLAM (mines1): one scan per line.

Column 0 is the time in microseconds, 2 and 3 the left and right encoder counts, 24 to 705 the 682 ranges in mm.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise, repeat
from math import pi
from operator import matmul
from typing import Final

import numpy as np

from slam.files.fields import BadLine, bounded, distances, stamp
from slam.files.logs.log import Log, scan_time
from slam.files.logs.odometry_resets import join_resets, note_resets
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.logs.stamps import drop_repeats, scan_times
from slam.files.logs.streamed_ranges import StreamedRanges, at_places
from slam.files.text_lines import read_lines
from slam.lidars import URG04LX
from slam.odometry import wheel_motion
from slam.pose import FloatArray, Pose2D, stack_poses

_FAN: Final = replace(URG04LX.lidar, range_max=5.6)
"""The first beam is assumed to be at step 44, as the log does not say it. The range limit is the DMAX that a URG-04LX
reports: 5 % of the ranges of mines1 are beyond 4.095 m."""
_TIME_INCREMENT: Final = 0.1 / 1024
"""Seconds: 600 turns a minute of 1024 steps."""
_T_BASE_LASER: Final = Pose2D(0.145, 0.0, 0.0)
_METRES_PER_COUNT: Final = 2.0 * pi * 0.077 / 2000
_TRACK: Final = 2.0 * 0.165
_FIRST_RANGE: Final = 24
_END: Final = _FIRST_RANGE + _FAN.beams
_COLUMNS: Final = (_END, _END + 1)
"""The recorder writes an additional column, 0, at the end of a line."""
_ERROR_CODES: Final = 20
"""Readings below 20 are not millimetres: 0 is no echo, the others are error codes (SCIP 2.0 specification, table 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class _Row:
    line: int
    stamp: float
    left: float
    right: float
    fingerprint: int


def recognises(line: bytes) -> bool:
    """Return True for a scan of such a log."""
    try:
        _parse(line.split(), 0)
    except BadLine:
        return False
    return True


def read(lines: Iterable[tuple[int, bytes]], statistics: ReadStatistics) -> Log:
    """Read the log in these numbered lines; LogError if there is no scan."""
    path, rows = statistics.path.resolve(), drop_repeats(list(_rows(lines, statistics)), statistics)
    if not rows:
        raise statistics.no_scans(f"lines of {_COLUMNS[-1]} columns")
    own, places = np.array([row.stamp for row in rows]), np.array([row.line for row in rows])
    stamps, _ = scan_times(own, None, places.tolist(), statistics)
    joined = join_resets(stamps, _dead_reckoning(rows))
    if joined.resets:
        note_resets(joined, (stamps - stamps[0]).tolist(), statistics)
    return Log(
        lidar=replace(_FAN, scan_time=scan_time(stamps)),
        T_base_laser=_T_BASE_LASER,
        stamps=stamps,
        ranges=StreamedRanges(
            statistics.path,
            lambda: (_parse(line.split(), 0)[1] for line in at_places(read_lines(path), places)),
            repeat(_FAN.beams, len(rows)),
        ),
        T_odom_base=joined.poses,
        time_increment=_TIME_INCREMENT,
        skipped=statistics.skipped,
        ignored=statistics.ignored,
        report=statistics.report(len(rows)),
        lost=statistics.lost,
    )


def _rows(lines: Iterable[tuple[int, bytes]], statistics: ReadStatistics) -> Iterator[_Row]:
    scans = 0
    for number, line in lines:
        words = line.split()
        if not words or words[0].startswith(b"#"):
            continue
        scans += 1
        if statistics.is_full(scans):
            return
        try:
            yield _parse(words, number)[0]
        except BadLine as fault:
            statistics.skip(str(fault), number, fault.detail)


def _parse(words: list[bytes], line: int) -> tuple[_Row, FloatArray]:
    if len(words) not in _COLUMNS:
        raise BadLine("truncated" if len(words) < _END else "too long")
    left, right = bounded(words[2:4], 1e10, "left_count right_count")
    ranges = _ranges(distances(words[_FIRST_RANGE:_END]))
    return _Row(line, stamp(words[0], unit=1e-6), left, right, hash(ranges.tobytes())), ranges


def _ranges(readings: FloatArray) -> FloatArray:
    """Convert readings in millimetres to metres, +inf for no echo and nan for an erroneous reading."""
    ranges = np.where(readings < _ERROR_CODES, np.nan, readings / 1000.0)
    ranges[(readings == 0.0) | (ranges > _FAN.range_max)] = np.inf
    return ranges


def _dead_reckoning(rows: list[_Row]) -> FloatArray:
    """Return ``T_odom_base`` at every row from the encoder counts, shape (N, 3)."""
    motions = (
        wheel_motion(_METRES_PER_COUNT * (b.left - a.left), _METRES_PER_COUNT * (b.right - a.right), _TRACK)
        for a, b in pairwise(rows)
    )
    return stack_poses(accumulate(motions, matmul, initial=Pose2D()))
