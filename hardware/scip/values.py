"""Numbers as 2, 3 or 4 characters: base 64, most significant digit first, each digit plus 0x30."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hardware.decode_error import DecodeError

IntArray = NDArray[np.int64]
_ZERO: Final = 0x30


def encode_values(values: IntArray, width: int) -> bytes:
    """``width`` characters for each of the values, shape (N,), which lie in [0, 64**width)."""
    if len(values) and not (0 <= values.min() and values.max() < 64**width):
        raise ValueError(f"{width} characters hold 0 to {64**width - 1}, not {values.min()} to {values.max()}")
    digits = values[:, None] >> (6 * np.arange(width - 1, -1, -1)) & 0x3F
    return (digits + _ZERO).astype(np.uint8).tobytes()


def decode_values(text: bytes, width: int) -> IntArray:
    """The values, shape (N,); Damaged for a character outside 0x30 to 0x6F or a number cut off."""
    if len(text) % width:
        raise DecodeError(f"{len(text)} characters are no whole values of {width}")
    digits = np.frombuffer(text, np.uint8).reshape(-1, width).astype(np.int64) - _ZERO
    if ((digits < 0) | (digits > 0x3F)).any():
        raise DecodeError("a character that is no digit")
    place_values: IntArray = 64 ** np.arange(width - 1, -1, -1)
    return digits @ place_values
