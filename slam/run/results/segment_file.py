"""Reads ``lines.geojson`` of a run, up to the first damage."""

from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Any, Final

import numpy as np

from slam.errors import InputError
from slam.files.json_files import parse_json, read_bounded
from slam.lines.segments import IntArray
from slam.pose import FloatArray

_NO_FEATURE: Final = (ValueError, KeyError, TypeError, IndexError, AttributeError, OverflowError)
"""Exceptions for a value that is not a feature of this file."""


def read_segments(path: Path) -> tuple[IntArray, FloatArray, str | None]:
    """Read the index of the scan of each segment, (M,), and its start and end, (M, 2, 2), metres.

    The third value describes the damage of the file, if any. InputError if it cannot be read.
    """
    try:
        text = read_bounded(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}; give the folder of a run") from error
    scans, ends, fault = list[int](), list[list[list[float]]](), None
    try:
        for feature in _features(text):
            scan, segment = _segment(feature)
            scans.append(scan)
            ends.append(segment)
    except _NO_FEATURE:
        fault = f"{path}: damaged after segment {len(scans)}"
    return np.array(scans, np.int64), np.array(ends, np.float64).reshape(-1, 2, 2), fault


def _features(text: bytes) -> Iterator[Any]:
    """Yield the features, of a complete file or of a truncated one, which has a line for each."""
    try:
        features = parse_json(text)["features"]
    except _NO_FEATURE:
        for line in text.splitlines()[1:]:
            yield parse_json(line.rstrip(b","))
        raise
    yield from features


def _segment(feature: Any) -> tuple[int, list[list[float]]]:
    """Return the index of the scan, and the two ends; raises one of _NO_FEATURE for anything else."""
    (x0, y0), (x1, y1) = feature["geometry"]["coordinates"]
    scan, numbers = feature["properties"]["scan"], [float(value) for value in (x0, y0, x1, y1)]
    if not isinstance(scan, int) or not 0 <= scan < 2**31 or not all(map(isfinite, numbers)):
        raise ValueError
    return scan, [numbers[:2], numbers[2:]]
