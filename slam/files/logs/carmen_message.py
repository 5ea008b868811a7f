"""Parsers of the messages of a CARMEN log."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, pi
from typing import Final, NamedTuple

import numpy as np

from slam.files.fields import BadLine, bounded, count, distances, impossible, stamp
from slam.lidars import Lidar, ordered_bearings, whole_steps
from slam.limits import BEAMS
from slam.pose import FloatArray, Pose2D

_POSE_NAMES: Final = "laser_x laser_y laser_theta robot_x robot_y robot_theta"
_CMU_WORDS: Final = 188
PREFIX: Final = b"hopslam_"
"""Prefix of this project's ``PARAM`` lines, which other readers ignore."""


@dataclass(frozen=True, slots=True, eq=False)
class Message:
    """One scan, without its ranges. Poses are x, y, theta in metres and radians, in the odometry frame."""

    line: int
    fan: Lidar
    """Fan and range limits; ``range_max`` is inf if the message has none; ``range_min`` and ``scan_time`` are 0."""
    fingerprint: int
    """Hash of the ranges."""
    T_odom_laser: tuple[float, float, float]
    T_odom_base: tuple[float, float, float]
    stamp: float
    logged: float | None
    """Time of the logger, seconds, if the line has it."""
    twist: Sequence[bytes] = ()
    """Two words: linear and angular velocity, m/s and rad/s, from the message; empty in an old one."""


Parsed = tuple[Message, FloatArray]
"""A message, and its ranges in metres."""


def _flaser(words: Sequence[bytes], line: int) -> Parsed:
    """Parse ``FLASER n ranges[n] laser x y theta, robot x y theta, ipc_timestamp host logger_timestamp``."""
    end = 2 + count(words, 1)
    _check_length(words, end + 9)
    return _message(line, _sick_fan(end - 2), words[2:end], words[end : end + 6], words[end + 6 :])


def _robotlaser1(words: Sequence[bytes], line: int) -> Parsed:
    """Parse a message ``ROBOTLASER1``.

    ``ROBOTLASER1 type start fov resolution max_range accuracy remission_mode n ranges[n] m remissions[m]``, then laser
    pose, robot pose, tv, rv, forward_safety, side_safety, turn_axis, ipc_timestamp, host, logger_timestamp.
    """
    end = 9 + count(words, 8)
    tail = end + 1 + count(words, end)
    _check_length(words, tail + 14)
    angle_min, _, angle_increment, range_max = bounded(
        words[2:6], names="start_angle field_of_view resolution maximum_range"
    )
    first, step, turned = ordered_bearings(angle_min, angle_increment, end - 9, _bearings)
    fan = Lidar(first, step, end - 9, 0.0, range_max, 0.0)
    readings = words[9:end][::-1] if turned else words[9:end]
    message, ranges = _message(line, fan, readings, words[tail : tail + 6], words[tail + 11 :])
    return replace(message, twist=words[tail + 6 : tail + 8]), ranges


def _bearings(angle_min: float, angle_increment: float) -> tuple[float, float]:
    return whole_steps(angle_min, angle_increment) or (angle_min, angle_increment)


def _cmu_laser(words: Sequence[bytes], line: int) -> Parsed:
    """Parse ``L x y theta, laser x y theta, ranges[180], time``: cm, radians and seconds, beams from right to left.

    CMU's course on probabilistic robotics uses this format.
    """
    if len(words) != _CMU_WORDS:
        raise BadLine("truncated" if len(words) < _CMU_WORDS else "too long")
    x, y, theta, laser_x, laser_y, laser_theta = bounded(words[1:7], names="x y theta laser_x laser_y laser_theta")
    laser = (laser_x / 100.0, laser_y / 100.0, laser_theta)
    base, ranges = (x / 100.0, y / 100.0, theta), distances(words[7:-1]) / 100.0
    return Message(line, _sick_fan(180), hash(ranges.tobytes()), laser, base, stamp(words[-1]), None), ranges


PARSERS: Final[dict[bytes, Callable[[Sequence[bytes], int], Parsed]]] = {
    b"FLASER": _flaser,
    b"ROBOTLASER1": _robotlaser1,
    b"L": _cmu_laser,
}
"""Parser of each laser message, from the words of a line and its number; BadLine if it is garbled."""


def _check_length(words: Sequence[bytes], length: int) -> None:
    """Raise BadLine for a wrong number of words; the last one, the logger's time, is optional: old logs have none."""
    if len(words) < length - 1:
        raise BadLine("truncated")
    if len(words) > length:
        raise BadLine("too long")


def _message(
    line: int, fan: Lidar, readings: Sequence[bytes], poses: Sequence[bytes], times: Sequence[bytes]
) -> Parsed:
    """Make the message of these words; ``times`` are ipc_timestamp, host, logger_timestamp."""
    turn = (fan.beams - 1) * fan.angle_increment
    if fan.beams < 1:
        raise impossible("number of beams", fan.beams)
    if excess := BEAMS.excess(fan.beams):
        raise BadLine("too many beams", excess)
    if fan.range_max <= 0.0:
        raise impossible("maximum_range", fan.range_max)
    if fan.angle_increment <= 0.0 or turn > 2.0 * pi + 1e-6:
        raise impossible("resolution", fan.angle_increment)
    laser_x, laser_y, laser_theta, x, y, theta = bounded(poses, names=_POSE_NAMES)
    ranges, laser, base = distances(readings), (laser_x, laser_y, laser_theta), (x, y, theta)
    return Message(line, fan, hash(ranges.tobytes()), laser, base, stamp(times[0]), _logged(times)), ranges


def _logged(times: Sequence[bytes]) -> float | None:
    try:
        return stamp(times[2]) if len(times) > 2 else None
    except BadLine:
        return None


def _sick_fan(beams: int) -> Lidar:
    """Return the fan of an old message, which has the number of beams only: 180 degrees, as in readlog.c.

    A log with 180 or 360 beams omits the last of the SICK's 181 or 361 beams.
    """
    steps = beams if beams in (180, 360) else max(beams - 1, 1)
    return Lidar(-pi / 2.0, pi / steps, beams, 0.0, inf, 0.0)


class CarmenParams(NamedTuple):
    """Values for which the laser messages have no field.

    They are the time between two beams, the range limits, and the start of the log in the map; seconds, metres and
    radians.

    If a log contains these parameters, a range of 0 is an error, and the velocities ``tv`` and ``rv`` are used.
    """

    time_increment: float
    range_min: float
    start_x: float
    start_y: float
    start_theta: float

    @property
    def start(self) -> Pose2D:
        """``T_map_base`` at the first scan."""
        return Pose2D(self.start_x, self.start_y, self.start_theta)


def parse_param(words: Sequence[bytes]) -> tuple[str, float] | None:
    """Parse one of this project's ``PARAM name value ipc_timestamp host logger_timestamp``; return name and value."""
    if len(words) < 3 or not words[1].startswith(PREFIX):
        return None
    try:
        return words[1].removeprefix(PREFIX).decode(errors="replace"), bounded(words[2:3])[0]
    except BadLine:
        return None


def params_of(values: dict[str, float]) -> CarmenParams | None:
    """Return the parameters; None if the log does not have them all."""
    known = {name: values[name] for name in CarmenParams._fields if name in values}
    return CarmenParams(**known) if len(known) == len(CarmenParams._fields) else None


def twists(messages: Sequence[Message]) -> FloatArray | None:
    """Return linear and angular velocity, (N, 2); None if a message has none that can be read."""
    try:
        rows = [bounded(message.twist) for message in messages]
    except BadLine:
        return None
    return np.array(rows) if all(len(row) == 2 for row in rows) else None
