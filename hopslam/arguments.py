"""Checks of the arguments of the API: a fault is one InputError with argument, value, index and advice."""

from math import isfinite, pi
from numbers import Real
from typing import Any, Final, NamedTuple

import numpy as np

from slam.errors import InputError, shown
from slam.limits import BEAMS
from slam.pose import FloatArray, Pose2D

MIN_BEAMS: Final = 3
"""Fewest beams of a scan: a line always passes through two points."""
FULL_TURN: Final = 2.0 * pi + 1e-6
"""A full turn in radians, with room for rounding."""
_FARTHEST: Final = 100.0
"""Metres; if half of the ranges are longer, their unit is not the metre."""
_FARTHEST_WHOLE: Final = 20.0
"""The same limit for ranges that are all whole numbers, as millimetres are."""
_LARGEST_ROBOT: Final = 20.0
"""Metres; no lidar is mounted farther from the middle of its robot."""
_LONGEST_REACH: Final = 1000.0
"""Metres that no lidar reaches."""
_LATEST: Final = 1e11
"""Seconds, some 3000 years; a longer time is in milliseconds or nanoseconds."""
_MISSING_VALUES: Final = "write inf where nothing came back, nan for an erroneous reading"


def checked_ranges(given: Any) -> FloatArray:
    """The ranges of a scan, (N,), metres; ``inf``, ``-inf`` and ``nan`` have the meaning of REP-117."""
    ranges = _row("ranges", given, _MISSING_VALUES)
    if len(ranges) < MIN_BEAMS:
        raise InputError(f"ranges has {len(ranges)} values; a scan needs {MIN_BEAMS} or more")
    if excess := BEAMS.excess(len(ranges)):
        raise InputError(f"ranges: {excess}")
    finite = np.isfinite(ranges)
    if (ranges[finite] < 0.0).any():
        k = int(np.flatnonzero(finite & (ranges < 0.0))[0])
        raise InputError(f"ranges[{k}] is {ranges[k]:g}, below 0; {_MISSING_VALUES}")
    if (ranges[finite] > _FARTHEST_WHOLE).any():
        _check_metres(ranges[finite])
    return ranges


def _check_metres(measured: FloatArray) -> None:
    middle, whole = float(np.median(np.minimum(measured, 1e9))), np.array_equal(measured, np.round(measured))
    if middle <= (_FARTHEST_WHOLE if whole else _FARTHEST):
        return
    unit, divisor = (
        ("millimetres", "1000") if middle >= _LONGEST_REACH else ("millimetres or centimetres", "1000 or 100")
    )
    raise InputError(f"ranges look like {unit}: their median is {middle:g}; give metres: divide by {divisor}")


def checked_angles(given: Any, count: int) -> FloatArray:
    """Check the bearings, (N,), radians, and that there is one for each of the ``N`` beams."""
    angles = _row("angles", given, "each beam has a bearing")
    if len(angles) != count:
        raise InputError(f"angles has {len(angles)} values for {count} ranges; give one angle for each range")
    return angles


def checked_pose(name: str, given: Any) -> Pose2D:
    """Convert a pose given as Pose2D or as x, y, theta; metres and radians."""
    if isinstance(given, Pose2D):
        given = (given.x, given.y, given.theta)
    row = _row(name, given, "give x, y, theta in metres and radians")
    if len(row) != 3:
        raise InputError(f"{name} has {len(row)} values; give three: x, y, theta in metres and radians")
    for k in np.flatnonzero(~np.isfinite(row)):
        part = ("x", "y", "theta")[k]
        raise InputError(f"{name}[{k}], {part}, is {row[k]}, not finite; leave scans without a pose out")
    return Pose2D.from_array(row)


def checked_start(name: str, given: Any) -> Pose2D:
    """Return the pose; InputError for an angle beyond one turn, which must be degrees."""
    pose = checked_pose(name, given)
    if abs(pose.theta) > FULL_TURN:
        raise InputError(f"{name}[2], theta, is {pose.theta:g} and looks like degrees; give radians")
    return pose


def checked_mount(name: str, given: Any) -> Pose2D:
    """Check the pose of a lidar on its robot; InputError for millimetres and degrees."""
    pose = checked_start(name, given)
    if (distance := pose.distance(Pose2D())) > _LARGEST_ROBOT:
        raise InputError(f"{name} is {distance:g} from the robot and looks like millimetres; give metres")
    return pose


def checked_number(name: str, given: Any, least: float | None = None, cure: str = "") -> float:
    """Check a number that is not nan, and is at least ``least`` where that is given."""
    end = f"; {cure}" if cure else ""
    if not _is_number(given):
        raise InputError(f"{name} is {shown(given)}, not a number{end}")
    number = float(given)
    if number != number or (least is not None and number < least):
        raise InputError(f"{name} is {number:g}, not {f'{least:g} or more' if least is not None else 'a number'}{end}")
    return number


class LidarTraits(NamedTuple):
    """Minimum and maximum range, metres, and time between two beams, seconds, 0 if unknown."""

    range_min: float
    range_max: float
    time_increment: float


def checked_lidar(range_min: Any, range_max: Any, time_increment: Any) -> LidarTraits:
    """Check the properties of the lidar other than its ranges and angles."""
    near = checked_number("range_min", range_min, 0.0, "give metres")
    far = checked_number("range_max", range_max, near, "give metres, or leave it out")
    if isfinite(far) and far >= _LONGEST_REACH:
        raise InputError(f"range_max is {far:g} and looks like millimetres; give metres, or leave it out")
    return LidarTraits(
        near, far, checked_number("time_increment", time_increment, 0.0, "give the seconds between beams")
    )


def checked_stamp(given: Any) -> float:
    """Check a time in seconds."""
    stamp = checked_number("stamp", given, cure="give the time of the first beam in seconds")
    if not isfinite(stamp):
        raise InputError(f"stamp is {stamp:g}, not finite; give the time of the first beam in seconds")
    if abs(stamp) > _LATEST:
        raise InputError(f"stamp is {stamp:g} and looks like milliseconds or nanoseconds; give seconds")
    return stamp


def checked_seed(given: Any) -> int:
    """Check a whole number, 0 or more."""
    if not isinstance(given, int | np.integer) or isinstance(given, bool) or given < 0:
        raise InputError(f"seed is {shown(given)}; give a whole number, 0 or more")
    return int(given)


def _row(name: str, given: Any, cure: str) -> FloatArray:
    """Copy a row of numbers into a new array."""
    if given is None:
        raise InputError(f"{name} is None; {cure}")
    if isinstance(given, np.ma.MaskedArray):
        given = np.ma.filled(given.astype(np.float64), np.nan)
    try:
        array = np.asarray(given)
    except ValueError as error:  # rows of different lengths
        raise InputError(f"{name}{_fault_of_items(given)}; {cure}") from error
    if array.ndim != 1:
        raise InputError(f"{name} has shape {array.shape}; {_cure_of_shape(name, array)}")
    if len(array) and array.dtype.kind not in "iuf" and not all(map(_is_number, array)):
        raise InputError(f"{name}{_fault_of_items(given)}; {cure}")
    try:
        return np.array(array, np.float64)
    except OverflowError as error:
        raise InputError(f"{name} is not a row of numbers; {cure}") from error


def _cure_of_shape(name: str, array: Any) -> str:
    if array.ndim == 0:
        return "give a row of numbers"
    if 1 in array.shape:
        return f"give a row of numbers, such as numpy.ravel({name})"
    return "give one scan at a time, a row of numbers"


def _fault_of_items(items: Any) -> str:
    """Describe the first item that is not a number, as in ``[3] is None``."""
    for k, item in enumerate(items):
        if not _is_number(item):
            return f"[{k}] is {shown(item)}, not a number"
    return " is not a row of numbers"


def _is_number(item: Any) -> bool:
    return isinstance(item, Real | np.integer | np.floating) and not isinstance(item, bool | np.bool_)
