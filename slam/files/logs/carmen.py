"""CARMEN logs: text, one message a line, the laser messages carrying the wheel odometry too.

The messages are those of http://carmen.sourceforge.net/logger_playback.html and of CARMEN's own reader, readlog.c.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from slam.files.fields import BadLine
from slam.files.logs.carmen_message import PARSERS, Message, params_of, parse_param, twists
from slam.files.logs.log import Log, lidar_of, scan_time, stacked
from slam.files.logs.odometry_resets import join_resets, note_resets
from slam.files.logs.outliers import drop_outliers
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.logs.stamps import drop_repeats, scan_times
from slam.lidars import Lidar
from slam.pose import FloatArray, Pose2D, relative_poses, wrap_angle

_TYPES: Final = frozenset(
    b"FLASER RLASER LASER3 LASER4 ROBOTLASER1 ROBOTLASER2 RAWLASER1 RAWLASER2 RAWLASER3 RAWLASER4"
    b" ODOM TRUEPOS PARAM SYNC L O".split()
)
_OLD_RANGE_MAX: Final = 80.0
"""Metres: what readlog.c takes for the reach of an old message."""
_SICK_CODES: Final = ((81.83, 81.92), (8.183, 8.192))
"""A SICK's readings are 13 bits of centimetres or millimetres, those from 8183 on error codes."""
_RIGID: Final = (0.02, 0.02, 0.01)
"""A mount does not move by more than this: x and y in metres, theta in radians."""


def recognises(line: bytes) -> bool:
    """True for a message of a CARMEN log."""
    words = line.split(maxsplit=1)
    return bool(words) and words[0] in _TYPES


def read(lines: Iterable[tuple[int, bytes]], statistics: ReadStatistics) -> Log:
    """The log in these numbered lines; LogError when there is not one scan."""
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
    ranges = stacked([message.ranges for message in messages])
    robot = np.array([message.T_odom_base for message in messages])
    laser = np.array([message.T_odom_laser for message in messages])
    range_max = _reach(lidar, ranges)
    ranges[ranges == 0.0] = np.inf if params is None else np.nan
    ranges[ranges >= range_max] = np.inf
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
        ranges=ranges,
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
    """Times of the scans; those of the logger help where they are known of all."""
    logged = [message.logged for message in messages if message.logged is not None]
    received = np.array(logged) if len(logged) == len(messages) else None
    own = np.array([message.stamp for message in messages])
    return scan_times(own, received, [message.line for message in messages], statistics)[0]


def _messages(
    lines: Iterable[tuple[int, bytes]], statistics: ReadStatistics, values: dict[str, float]
) -> Iterator[Message]:
    """The laser messages; this project's parameters go to ``values``; others are counted, garbled lines skipped."""
    for number, line in lines:
        words = line.split()
        if not words or words[0].startswith(b"#"):
            continue
        if words[0] in PARSERS:
            try:
                yield PARSERS[words[0]](words, number)
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


def _reach(fan: Lidar, ranges: FloatArray) -> float:
    """The range, metres, from which a reading means that nothing came back.

    An old message does not say. Then it is the largest reading that the log holds twice, and 80 m at the most.
    """
    reach = fan.range_max
    if not np.isfinite(reach):
        readings, counts = np.unique(ranges, return_counts=True)
        reach = min(_OLD_RANGE_MAX, float(np.max(readings[counts > 1], initial=0.0)) or _OLD_RANGE_MAX)
    return next((first for first, end in _SICK_CODES if first <= reach < end), reach)


def _mount(robot: FloatArray, laser: FloatArray, statistics: ReadStatistics) -> Pose2D:
    """``T_base_laser``: the median of how the laser poses lie to the robot poses.

    Where that is no fixed mount, the laser poses are a mapper's corrections; then none is known, and it is identity.
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
