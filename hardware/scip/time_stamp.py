"""The sensor's time stamps: milliseconds in 24 bits on the wire, seconds here."""

from typing import Final

import numpy as np

from hardware import DecodeError
from hardware.scip.encoding import decode_values, encode_values

_COUNT: Final = 2**24
TIME_WRAP: Final = _COUNT / 1000.0
"""Seconds after which the sensor's clock wraps: 4.66 h."""


def encode_time(seconds: float) -> bytes:
    """Return the four characters that stamp a scan, and answer TM1."""
    return encode_values(np.array([_milliseconds(seconds)]), 4)


def decode_time(text: bytes) -> float:
    """Return seconds; DecodeError unless there are four characters."""
    if len(text) != 4:
        raise DecodeError(f"a time of {len(text)} characters")
    return int(decode_values(text, 4)[0]) / 1000.0


def encode_hex_time(seconds: float) -> str:
    """Return the six hexadecimal digits in the answer to II."""
    return f"{_milliseconds(seconds):06X}"


def decode_hex_time(text: str) -> float:
    """Return seconds; DecodeError for text that is not a number."""
    try:
        return int(text, 16) / 1000.0
    except ValueError:
        raise DecodeError("TIME is not a number") from None


def _milliseconds(seconds: float) -> int:
    return round(seconds * 1000.0) % _COUNT
