"""The segments that an extractor of the user's own finds, checked."""

from __future__ import annotations

from typing import Final

import numpy as np

from slam.config import OwnMethod
from slam.errors import InputError
from slam.lines.segments import Segments
from slam.own_code import expect, kind_of
from slam.scan import LaserScan

_COLUMNS: Final = {"first": (), "last": (), "rho": (), "theta": (), "start": (2,), "end": (2,)}
"""Shape of one segment's entry in each array."""


def own_segments(scan: LaserScan, config: OwnMethod) -> Segments:
    """The segments of the scan; InputError, which names the extractor, where it returns none such."""
    segments: Segments = config.call(scan)
    expect(config.method, segments, Segments)
    count = np.shape(segments.rho)[:1]
    for name, column in _COLUMNS.items():
        array = getattr(segments, name)
        if not isinstance(array, np.ndarray) or array.shape != (*count, *column):
            found = f"of shape {array.shape}" if isinstance(array, np.ndarray) else f"of type {kind_of(array)}"
            raise InputError(
                f"{config.method} returned Segments whose {name} is {found}, not an array of shape "
                f"{(*count, *column)}; see docs/extend.md"
            )
    return segments
