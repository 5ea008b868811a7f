"""Reads ``steps.csv`` of a run, up to the first damaged line."""

from array import array
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.errors import InputError
from slam.files.fields import BadLine, bounded
from slam.files.text_lines import read_lines
from slam.limits import SCANS

_NEEDED: Final = (
    "stamp", "mapped", "iterations", "converged", "map_points", "segments", "extraction_ms", "slam_ms", "v", "omega",
    "lost",
)  # fmt: skip
"""Columns that every run has."""
_MAY_BE_EMPTY: Final = ("cov_", "battery", "sonar_")
"""Prefixes of optional columns."""
_LARGEST: Final = 1e18


def read_steps(path: Path) -> tuple[NDArray[Any], str | None]:
    """Read the rows up to the first damaged line, as records (K,) with a field for each column.

    Also return the fault of that line, None for an intact file. InputError for a damaged first line.
    """
    values, fault = array("d"), None
    with closing(read_lines(path)) as lines:
        names = _names(next(lines, (1, b""))[1], path)
        for number, line in lines:
            if excess := SCANS.excess(len(values) // len(names) + 1):
                fault = f"{path.name}: line {number}: {excess}"
                break
            try:
                values.extend(_row(line, names))
            except BadLine as error:
                fault = f"{path.name}: line {number} is {error}"
                break
    return np.array(values).view([(name, np.float64) for name in names]), fault


def _names(head: bytes, path: Path) -> list[str]:
    names = head.decode(errors="replace").strip().split(",")
    missing = [name for name in _NEEDED if name not in names]
    if missing or len(set(names)) < len(names) or "" in names:
        fault = f"has no column {missing[0]}" if missing else "has a column twice, or one without a name"
        raise InputError(f"{path}: line 1 {fault}; make it again with hopslam replay of the run's folder")
    return names


def _row(line: bytes, names: list[str]) -> tuple[float, ...]:
    words = line.strip().split(b",")
    if len(words) != len(names):
        raise BadLine("truncated" if len(words) < len(names) else "too long")
    empty = [name.startswith(_MAY_BE_EMPTY) and not word for name, word in zip(names, words, strict=True)]
    values = bounded([word or b"0" for word in words] if any(empty) else words, _LARGEST)
    return tuple(np.nan if void else value for void, value in zip(empty, values, strict=True))
