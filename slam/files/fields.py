"""Conversion of the fields of a line of a log to numbers."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from slam.errors import LogError
from slam.pose import FloatArray

LARGEST: Final = 1e7
"""Largest believable position (metres), angle (radians) or wheel travel; a larger number is garbled."""


class BadLine(Exception):
    """A line that cannot be used; the message is the kind of fault that the report counts. The readers catch it."""

    def __init__(self, kind: str, detail: str = "") -> None:
        super().__init__(kind)
        self.detail = detail
        """The wrong field and its value, if known."""


def impossible(field: str, value: object) -> BadLine:
    """Make the error of a field with an impossible value."""
    shown = f"{value:.9g}" if isinstance(value, float) else str(value)
    return BadLine("impossible value", f"{field} {shown}")


def numbers(words: Sequence[bytes]) -> FloatArray:
    """Convert words to numbers, which may be inf or nan."""
    try:
        return np.array([float(word) for word in words])
    except ValueError:
        raise BadLine("not a number") from None


def bounded(words: Sequence[bytes], largest: float = LARGEST, names: str = "") -> list[float]:
    """Convert words to finite numbers of a believable size; ``names`` are the names of the fields."""
    values = numbers(words)
    for index in np.flatnonzero(~(np.abs(values) <= largest)).tolist():
        named = names.split()
        raise impossible(named[index] if index < len(named) else f"number {index + 1}", float(values[index]))
    believable: list[float] = values.tolist()
    return believable


def distances(words: Sequence[bytes]) -> FloatArray:
    """Convert words to numbers from 0 to inf."""
    values = numbers(words)
    for index in np.flatnonzero(~(values >= 0.0)).tolist():
        raise impossible(f"range {index + 1} of {len(values)}", float(values[index]))
    return values


def stamp(word: bytes, unit: float = 1.0) -> float:
    """Convert a time in units of ``unit`` seconds to seconds, rounded to the microsecond, as in logs and TUM files."""
    return round(bounded([word], 1e18, "stamp")[0] * unit, 6)


def count(words: Sequence[bytes], index: int) -> int:
    """Return the field with this index as a count."""
    try:
        value = int(words[index])
    except IndexError:
        raise BadLine("truncated") from None
    except ValueError:
        raise BadLine("not a number") from None
    if value < 0:
        raise impossible("number of beams", value)
    return value


def table_row(words: Sequence[bytes], columns: str, where: str) -> list[float]:
    """Read one line of a table with these columns; LogError, with ``where``, for any other line."""
    try:
        values = bounded(words, 1e18, columns)
    except BadLine as fault:
        raise LogError(f"{where}: {fault}; need {columns}") from None
    if len(values) != len(columns.split()):
        raise LogError(f"{where}: {len(values)} numbers; need {columns}")
    return values
