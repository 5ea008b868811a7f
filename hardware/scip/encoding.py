"""SCIP's digits of six bits, each plus 0x30: numbers in base 64, and the sum that ends a line of SCIP 2.0.

The sum includes every character of a line: in lines of data the semicolon is the digit 11. Only the semicolon at the
end of a ``KEY:value;`` line of VV, PP and II is left out.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hardware import DecodeError

IntArray = NDArray[np.int64]
_ZERO: Final = 0x30
_MASK: Final = 0x3F


def encode_values(values: IntArray, width: int) -> bytes:
    """Return ``width`` characters for each value, shape (N,), in [0, 64**width); the most significant digit first."""
    if len(values) and not (0 <= values.min() and values.max() < 64**width):
        raise ValueError(f"{width} characters hold 0 to {64**width - 1}, not {values.min()} to {values.max()}")
    digits = values[:, None] >> (6 * np.arange(width - 1, -1, -1)) & _MASK
    return (digits + _ZERO).astype(np.uint8).tobytes()


def decode_values(text: bytes, width: int) -> IntArray:
    """Return the values, shape (N,); DecodeError for a character outside 0x30 to 0x6F or a number that is cut off."""
    if len(text) % width:
        raise DecodeError(f"{len(text)} characters are not whole values of {width}")
    digits = np.frombuffer(text, np.uint8).reshape(-1, width).astype(np.int64) - _ZERO
    if ((digits < 0) | (digits > _MASK)).any():
        raise DecodeError("a character that is not a digit")
    place_values: IntArray = 64 ** np.arange(width - 1, -1, -1)
    return digits @ place_values


def line_sum(text: bytes) -> int:
    """Return the character that stands for the sum of a line."""
    return (sum(text) & _MASK) + _ZERO


def add_sum(line: bytes, entry: bool = False) -> bytes:
    """Return the line with its sum; ``entry`` is True for ``KEY:value;``."""
    return line + bytes([line_sum(line.removesuffix(b";") if entry else line)])


def check_sum(line: bytes, entry: bool = False) -> bytes:
    """Return the line without its sum; DecodeError if the sum is wrong.

    ``entry`` is True for ``KEY:value;``, where some sensors include the last semicolon in the sum.
    """
    if not line:
        raise DecodeError("an empty line has no sum")
    text = line[:-1]
    if line[-1] != line_sum(text) and not (entry and line[-1] == line_sum(text.removesuffix(b";"))):
        raise DecodeError("sum")
    return text
