"""CARMEN logs: text, one message per line; the laser messages include the wheel odometry.

The messages are those of http://carmen.sourceforge.net/logger_playback.html and of CARMEN's own reader, readlog.c.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from slam.files.fields import BadLine
from slam.files.logs.carmen_message import PARSERS, Message, params_of, parse_param, twists
from slam.files.logs.log import Log, lidar_of, scan_time
from slam.files.logs.odometry_resets import join_resets, note_resets
from slam.files.logs.outliers import drop_outliers
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.logs.stamps import drop_repeats, scan_times
from slam.files.logs.streamed_ranges import StreamedRanges, at_places
from slam.files.text_lines import read_lines
from slam.lidars import Lidar
from slam.pose import FloatArray, Pose2D, relative_poses, wrap_angle

_TYPES: Final = frozenset(
    b"FLASER RLASER LASER3 LASER4 ROBOTLASER1 ROBOTLASER2 RAWLASER1 RAWLASER2 RAWLASER3 RAWLASER4"
    b" ODOM TRUEPOS PARAM SYNC L O".split()
)
_OLD_RANGE_MAX: Final = 80.0
"""Metres: range limit of an old message in readlog.c."""
_SICK_CODES: Final = ((81.83, 81.92), (8.183, 8.192))
"""Readings of a SICK have 13 bits, centimetres or millimetres; 8183 and more are error codes."""
_SINGLE_READINGS: Final = 100_000
"""Number of largest readings that are remembered after they occurred once, to detect a second occurrence."""
_RIGID: Final = (0.02, 0.02, 0.01)
"""Largest variation of a fixed mount: x and y in metres, theta in radians."""


def recognises(line: bytes) -> bool:
    """Return True for a message of a CARMEN log."""
    words = line.split(maxsplit=1)
    return bool(words) and words[0] in _TYPES


def read(lines: Iterable[tuple[int, bytes]], statistics: ReadStatistics) -> Log:
    """Read the log in these numbered lines; LogError if there is no scan."""
    values: dict[str, float] = {}
    messages = drop_repeats(list(_messages(lines, statistics, values)), statistics)
    messages = drop_outliers(
        messages, lambda m: (m.stamp, *m.T_odom_base[:2]), lambda m: statistics.skip("outlying pose", m.line),
        statistics.notes,
    )  # fmt: skip
    if not messages:
        raise statistics.no_scans("FLASER or ROBOTLASER1 messages")
    stamps = _stamps(messages, statistics)
    params = params_of(values)
    between = params.time_increment if params else 0.0
    lidar, table = lidar_of([message.fan for message in messages], [between] * len(messages))
    path, places = statistics.path.resolve(), np.array([message.line for message in messages])
    robot = np.array([message.T_odom_base for message in messages])
    laser = np.array([message.T_odom_laser for message in messages])
    range_max, at_zero = _reach(lidar, lambda: _readings(path, places)), np.inf if params is None else np.nan
    mount, joined = _mount(robot, laser, statistics), join_resets(stamps, robot)
    if joined.resets:
        note_resets(joined, (stamps - stamps[0]).tolist(), statistics)
    if table is not None:
        statistics.notes.append(table.note)
    return Log(
        lidar=replace(
            lidar, range_min=params.range_min if params else 0.0, range_max=range_max, scan_time=scan_time(stamps)
        ),
        T_base_laser=mount,
        stamps=stamps,
        ranges=StreamedRanges(
            statistics.path,
            lambda: (_ranges(row, at_zero, range_max) for row in _readings(path, places)),
            [message.fan.beams for message in messages],
        ),
        T_odom_base=relative_poses(joined.poses[0], joined.poses),
        time_increment=between,
        skipped=statistics.skipped,
        ignored=statistics.ignored,
        report=statistics.report(len(messages)),
        twists=twists(messages) if params else None,
        start=params.start if params else Pose2D(),
        fans=table,
        lost=statistics.lost,
    )


def _stamps(messages: Sequence[Message], statistics: ReadStatistics) -> FloatArray:
    """Return the times of the scans; logger times help if all scans have them."""
    logged = [message.logged for message in messages if message.logged is not None]
    received = np.array(logged) if len(logged) == len(messages) else None
    own = np.array([message.stamp for message in messages])
    return scan_times(own, received, [message.line for message in messages], statistics)[0]


def _messages(
    lines: Iterable[tuple[int, bytes]], statistics: ReadStatistics, values: dict[str, float]
) -> Iterator[Message]:
    """Yield the laser messages, and put the parameters that are used into ``values``.

    Other messages are counted, and garbled lines are skipped.
    """
    scans = 0
    for number, line in lines:
        words = line.split()
        if not words or words[0].startswith(b"#"):
            continue
        if words[0] in PARSERS:
            scans += 1
            if statistics.is_full(scans):
                return
            try:
                yield PARSERS[words[0]](words, number)[0]
            except BadLine as fault:
                statistics.skip(str(fault), number, fault.detail)
        elif words[0] == b"PARAM" and (named := parse_param(words)):
            values.setdefault(*named)
        else:
            _pass_by(words[0], number, statistics)


def _pass_by(name: bytes, line: int, statistics: ReadStatistics) -> None:
    if name in _TYPES:
        statistics.ignored[name.decode()] += 1
    elif name.isupper() and name.replace(b"_", b"").isalnum():
        statistics.ignored["other"] += 1
    else:
        statistics.skip("not a message", line, scan=False)


def _readings(path: Path, places: Iterable[int]) -> Iterator[FloatArray]:
    """Yield the readings of the laser messages in the lines with these numbers, metres."""
    for line in at_places(read_lines(path), places):
        words = line.split()
        yield PARSERS[words[0]](words, 0)[1]


def _ranges(readings: FloatArray, at_zero: float, range_max: float) -> FloatArray:
    return np.where(readings == 0.0, at_zero, np.where(readings >= range_max, np.inf, readings))


def _reach(fan: Lidar, readings: Callable[[], Iterable[FloatArray]]) -> float:
    """Return the range, metres, from which a reading means no echo.

    An old message does not state it. Then it is the largest reading that occurs twice in the log, and 80 m at most.
    """
    reach = fan.range_max
    if not np.isfinite(reach):
        reach = min(_OLD_RANGE_MAX, _largest_twice(readings()) or _OLD_RANGE_MAX)
    return next((first for first, end in _SICK_CODES if first <= reach < end), reach)


def _largest_twice(rows: Iterable[FloatArray]) -> float:
    """Return the largest value that occurs more than once; 0 if none does."""
    largest, once = 0.0, np.array([])
    for row in rows:
        values, counts = np.unique(np.concatenate([once, row[row > largest]]), return_counts=True)
        largest = float(np.max(values[counts > 1], initial=largest))
        once = values[values > largest][-_SINGLE_READINGS:]
    return largest


def _mount(robot: FloatArray, laser: FloatArray, statistics: ReadStatistics) -> Pose2D:
    """Return ``T_base_laser``, the median pose of the laser relative to the robot.

    If it varies, the laser poses are a mapper's corrections; then the mount is unknown, and identity is returned.
    """
    offsets = relative_poses(robot, laser)
    offsets[:, 2] = np.unwrap(offsets[:, 2])
    mount = np.median(offsets, axis=0)
    if (np.median(np.abs(offsets - mount), axis=0) > _RIGID).any():
        statistics.notes.append(
            "the laser poses are not fixed to the robot's, so the laser is taken to sit on its centre"
        )
        return Pose2D()
    x, y, theta = mount.tolist()
    return Pose2D(x, y, wrap_angle(theta))
