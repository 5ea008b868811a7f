"""Extraction of line segments by the configured method; the results of a user's own extractor are checked."""

from dataclasses import replace
from math import hypot
from typing import Any, Final

import numpy as np

from slam.config import ChiSquareConfig, LineConfig, OwnMethod
from slam.errors import InputError
from slam.lines.chi_square import segments_by_chi_square
from slam.lines.hopping import segments_by_hopping
from slam.lines.range_noise import RangeNoise
from slam.lines.segments import IntArray, Segments
from slam.own_checks import expect, expect_array, expect_numbers
from slam.scan import LaserScan

_COLUMNS: Final[dict[str, tuple[type[float], tuple[int, ...]]]] = {
    "rho": (float, ()), "theta": (float, ()), "start": (float, (2,)), "end": (float, (2,)),
    "first": (int, ()), "last": (int, ()),
    "covariance": (float, (2, 2)), "start_covariance": (float, (2, 2)), "end_covariance": (float, (2, 2)),
}  # fmt: skip
"""Kind of the numbers in each array, and the shape of one segment's entry; covariances may be None."""


def extract_segments(scan: LaserScan, config: LineConfig, noise: RangeNoise | None = None) -> Segments:
    """Find the segments of the scan, sensor frame; their indices refer to ``scan.points()``.

    ``noise`` is that of its ranges; without it, it is estimated from this one scan and the settings.
    """
    if isinstance(config, ChiSquareConfig):
        return segments_by_chi_square(scan, config, noise)
    segments = (
        _own_segments(scan, config) if isinstance(config, OwnMethod) else segments_by_hopping(scan.points(), config)
    )
    return segments if segments.noise is not None or noise is None else replace(segments, noise=noise)


def _own_segments(scan: LaserScan, config: OwnMethod) -> Segments:
    """Call the extractor; InputError names it, the field and the invalid value."""
    segments: Segments = config.call(scan)
    expect(config.method, segments, Segments)
    what = f"{config.method} returned Segments whose"
    count = len(segments.rho) if np.ndim(segments.rho) else 0
    arrays: dict[str, Any] = {
        name: expect_array(f"{what} {name}", array, (count, *shape), kind)
        for name, (kind, shape) in _COLUMNS.items()
        if (array := getattr(segments, name)) is not None or not name.endswith("covariance")
    }
    checked = replace(segments, **arrays)
    _check_places(what, checked.first, checked.last, int(scan.echoes.sum()))
    if segments.noise is not None:
        _check_noise(what, segments.noise)
    return checked


def _check_places(what: str, first: IntArray, last: IntArray, points: int) -> None:
    """Check that the segments lie among the points of the scan, in their order, and share a corner at most."""
    for m in np.flatnonzero((first < 0) | (last < first) | (last >= points)):
        raise InputError(
            f"{what} first[{m}] is {first[m]} and last[{m}] is {last[m]}, not 0 <= first <= last < {points}, "
            "the number of points of the scan; see docs/extend.md"
        )
    for m in np.flatnonzero(first[1:] < last[:-1]):
        raise InputError(
            f"{what} first[{m + 1}] is {first[m + 1]}, before last[{m}], which is {last[m]}: segments stand in "
            "the order of the scan and share a corner at most; see docs/extend.md"
        )


def _check_noise(what: str, noise: RangeNoise) -> None:
    """Check that the standard deviation is above 0 at every range; ``near_range`` may be infinite."""
    expect(f"{what} noise", noise, RangeNoise)
    expect_numbers(f"{what} noise.", noise, ("near", "far", "floor"))
    if not min(noise) >= 0 or hypot(noise.near, noise.floor) == 0 or hypot(noise.far, noise.floor) == 0:
        raise InputError(f"{what} noise is {noise}, and not more than 0 at every range; see docs/extend.md")
