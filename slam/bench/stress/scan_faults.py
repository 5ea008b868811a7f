"""Faults of the scans: fewer of them, fewer beams, worse ranges. Each makes a new log of a log and one value."""

from dataclasses import replace
from typing import Final

import numpy as np

from slam.files.logs.log import Log, scan_time
from slam.pose import FloatArray, path_lengths

_NEAREST: Final = 0.02
"""Metres: no range becomes shorter by noise."""
_STRETCHES: Final = 6
"""Stretches of the way among thin things ..."""
_STRETCH: Final = 3.0
"""... each that long, metres ..."""
_BEGINNINGS: Final = 0.08, 0.9
"""... the first and the last of which begin at these shares of the way."""
_THIN_FROM: Final = 0.4
"""Metres to the nearest thin thing ..."""
_THIN_BEFORE: Final = 0.1
"""... and from the farthest to the wall behind it; a range needs twice the former to hold one."""


def every_nth(log: Log, value: float, random: np.random.Generator) -> Log:
    """Keep every Nth scan."""
    kept = slice(None, None, int(value))
    stamps = log.stamps[kept]
    return replace(
        log,
        lidar=replace(log.lidar, scan_time=scan_time(stamps)),
        stamps=stamps,
        ranges=log.ranges[kept],
        T_odom_base=log.T_odom_base[kept],
        twists=None if log.twists is None else log.twists[kept],
        T_map_base=None if log.T_map_base is None else log.T_map_base[kept],
    )


def every_nth_beam(log: Log, value: float, random: np.random.Generator) -> Log:
    """Keep every Nth beam."""
    step = int(value)
    ranges, fan = log.ranges[:, ::step], log.lidar
    lidar = replace(fan, beams=ranges.shape[1], angle_increment=step * fan.angle_increment)
    return replace(log, lidar=lidar, ranges=ranges, time_increment=step * log.time_increment)


def coarse_ranges(log: Log, value: float, random: np.random.Generator) -> Log:
    """Round the ranges to ``value`` metres."""
    return _with_ranges(log, np.round(log.ranges / value) * value)


def noisy_ranges(log: Log, value: float, random: np.random.Generator) -> Log:
    """Add white noise of ``value`` metres to the ranges."""
    return _with_ranges(log, np.maximum(log.ranges + random.normal(0.0, value, log.ranges.shape), _NEAREST))


def scattered_ranges(log: Log, value: float, random: np.random.Generator) -> Log:
    """Let a share ``value`` of the beams end on something thin before the wall, as chair legs are, anywhere between; in
    some stretches of the way."""
    way = path_lengths(log.T_odom_base)
    begin = np.linspace(*_BEGINNINGS, _STRETCHES) * way[-1]
    among = ((way[:, None] >= begin) & (way[:, None] < begin + _STRETCH)).any(axis=1)
    walls = np.where(np.isfinite(log.ranges), log.ranges, 0.0)
    hit = among[:, None] & (random.random(walls.shape) < value) & (walls > 2.0 * _THIN_FROM)
    thin = _THIN_FROM + random.random(walls.shape) * (walls - _THIN_FROM - _THIN_BEFORE)
    return _with_ranges(log, np.where(hit, thin, log.ranges))


def _with_ranges(log: Log, ranges: FloatArray) -> Log:
    """The log with these ranges; what reaches the sensor's end is no echo."""
    return replace(log, ranges=np.where(ranges >= log.lidar.range_max, np.inf, ranges))
