"""Variants of a recorded log that are harder: fewer scans, worse odometry, worse ranges."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.random import Generator

from slam.bench.stress.odometry_steps import chained, size_of_steps, steps
from slam.errors import InputError
from slam.files.logs import Log
from slam.lines.segments import IntArray
from slam.pose import FloatArray, path_lengths

SLIP: Final = float(np.radians(10.0))
"""Heading error of a slip, radians, to either side."""
LARGE_STEPS: Final = 5
"""The steps that ``blind`` sets to zero are drawn from the ``LARGE_STEPS * count`` largest ones."""
MIN_RANGE: Final = 0.02
"""Metres: noise makes no range shorter."""
STRETCHES: Final = np.linspace(0.08, 0.9, 6)
"""Starts of the stretches with clutter, as shares of the path length."""
STRETCH: Final = 3.0
"""Length of a stretch with clutter, metres."""
CLUTTER: Final = 0.4, 0.8
"""Least range of clutter, and least range of a wall that clutter may hide, metres."""

TINY_NOISE: Final = "noise=0.002"
"""Noise too small to matter, which makes runs with different seeds differ."""


def every(log: Log, n: float, _: Generator) -> Log:
    """Keep every n-th scan."""
    return _kept(log, np.arange(0, len(log), int(n)))


def beams(log: Log, n: float, _: Generator) -> Log:
    """Keep every n-th beam of every scan."""
    ranges, lidar = np.asarray(log.ranges)[:, :: int(n)], log.lidar
    lidar = replace(lidar, angle_increment=lidar.angle_increment * int(n), beams=ranges.shape[1])
    return replace(log, lidar=lidar, ranges=ranges, time_increment=log.time_increment * int(n))


def jitter(log: Log, metres: float, random: Generator) -> Log:
    """Add white noise with this standard deviation, metres, to every position of the odometry."""
    odometry = log.T_odom_base.copy()
    odometry[:, :2] += random.normal(0.0, metres, (len(log), 2))
    return replace(log, T_odom_base=odometry)


def scale(log: Log, share: float, random: Generator) -> Log:
    """Scale all distances by 1 + share, and each turn by 1 + share or 1 - share."""
    moved = steps(log.T_odom_base)
    to_left = moved[:, 2] > 0.0
    turn = np.concatenate([[0], np.cumsum(to_left[1:] != to_left[:-1])])
    moved[:, :2] *= 1.0 + share
    moved[:, 2] *= 1.0 + share * random.choice([-1.0, 1.0], turn[-1] + 1)[turn]
    return replace(log, T_odom_base=chained(log.T_odom_base[0], moved))


def slips(log: Log, count: float, random: Generator) -> Log:
    """Turn the heading of the odometry by SLIP to either side at ``count`` scans."""
    moved = steps(log.T_odom_base)
    at = random.choice(np.arange(5, len(moved)), int(count), replace=False)
    moved[at, 2] += SLIP * random.choice([-1.0, 1.0], len(at))
    return replace(log, T_odom_base=chained(log.T_odom_base[0], moved))


def blind(log: Log, count: float, random: Generator) -> Log:
    """Set ``count`` of the largest steps of the odometry to zero, as in a log with gaps."""
    moved = steps(log.T_odom_base)
    largest = np.argsort(-size_of_steps(moved), kind="stable")[: LARGE_STEPS * int(count)]
    moved[random.choice(largest, int(count), replace=False)] = 0.0
    return replace(log, T_odom_base=chained(log.T_odom_base[0], moved))


def stale(log: Log, share: float, random: Generator) -> Log:
    """Give this share of the scans the odometry of the scan before; the next scan has the right one again."""
    late = np.flatnonzero(random.random(len(log)) < share)
    late = late[late > 0]
    late = late[np.diff(late, prepend=-1) > 1]
    odometry = log.T_odom_base.copy()
    odometry[late] = odometry[late - 1]
    return replace(log, T_odom_base=odometry)


def coarse(log: Log, step: float, _: Generator) -> Log:
    """Round the ranges to multiples of ``step`` metres."""
    ranges = np.asarray(log.ranges)
    return replace(log, ranges=np.where(np.isfinite(ranges), np.round(ranges / step) * step, ranges))


def noise(log: Log, sigma: float, random: Generator) -> Log:
    """Add white noise with this standard deviation, metres, to the ranges."""
    ranges = np.asarray(log.ranges)
    noisy = np.maximum(ranges + random.normal(0.0, sigma, ranges.shape), MIN_RANGE)
    return replace(log, ranges=np.where(np.isfinite(ranges), noisy, ranges))


def scatter(log: Log, share: float, random: Generator) -> Log:
    """Add clutter in six stretches of the path: this share of the beams ends before the wall, as on chair legs."""
    distances, ranges = path_lengths(log.T_odom_base), np.asarray(log.ranges)
    begins = STRETCHES * distances[-1]
    cluttered = ((distances[:, None] >= begins) & (distances[:, None] < begins + STRETCH)).any(axis=1)
    nearest, least = CLUTTER
    hit = (random.random(ranges.shape) < share) & cluttered[:, None] & np.isfinite(ranges) & (ranges > least)
    before = nearest + random.random(ranges.shape) * (np.where(hit, ranges, 1.0) - nearest - 0.1)
    return replace(log, ranges=np.where(hit, before, ranges))


Variation = Callable[[Log, float, Generator], Log]
VARIATIONS: Final[dict[str, Variation]] = {
    variation.__name__: variation
    for variation in (every, beams, jitter, scale, slips, blind, stale, coarse, noise, scatter)
}
"""Changes to a log, by name."""


def made_harder(log: Log, variant: str, seed: int) -> Log:
    """Apply each part of a variant such as ``every=5,blind=10``; the empty one changes nothing.

    Each part has its own random numbers, from the seed and its place. InputError for an invalid part.
    """
    for place, (variation, value) in enumerate(_parts(variant)):
        _check_count(variant, variation, value, log)
        log = variation(log, value, np.random.default_rng([seed, place]))
    return log


def with_chance(variant: str) -> str:
    """Add TINY_NOISE to the variant if it has no random numbers, so that another seed gives another log."""
    if any(variation not in (every, beams, coarse) for variation, _ in _parts(variant)):
        return variant
    return ",".join(filter(None, (TINY_NOISE, variant)))


def _parts(variant: str) -> list[tuple[Variation, float]]:
    return [_part(variant, text.strip()) for text in variant.split(",") if text.strip()]


def _part(variant: str, text: str) -> tuple[Variation, float]:
    name, _, value = text.partition("=")
    try:
        number = float(value)
        if name not in VARIATIONS or not (number >= 1.0 if name in ("every", "beams") else 0.0 < number < np.inf):
            raise ValueError
    except ValueError:
        raise InputError(
            f"variant {variant!r}: {text!r} is not valid; need NAME=NUMBER with one of {', '.join(VARIATIONS)}, as in "
            "every=5,blind=10"
        ) from None
    return VARIATIONS[name], number


def _check_count(variant: str, variation: Variation, value: float, log: Log) -> None:
    """Raise InputError if a log has too few scans, beams or steps for the variant."""
    most = {
        "every": len(log) // 2,
        "beams": log.lidar.beams // 3,
        "slips": len(log) - 6,
        "blind": (len(log) - 1) // LARGE_STEPS,
    }
    name = variation.__name__
    if value > most.get(name, np.inf):
        raise InputError(
            f"variant {variant!r}: {name}={value:g} is too much for {len(log)} scans of {log.lidar.beams} beams; "
            f"{max(most[name], 0)} is the most"
        )


def _kept(log: Log, rows: IntArray) -> Log:
    def some(array: FloatArray | None) -> FloatArray | None:
        return None if array is None else array[rows]

    return replace(
        log, stamps=log.stamps[rows], ranges=np.asarray(log.ranges)[rows], T_odom_base=log.T_odom_base[rows],
        twists=some(log.twists), T_map_base=some(log.T_map_base),
    )  # fmt: skip
