"""Ranges on the wire: a time stamp, and whole millimetres of which those below 20 name errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from hardware.decode_error import DecodeError
from hardware.scip.commands import Measure
from hardware.scip.reply import Reply, data_lines
from hardware.scip.values import IntArray, decode_values, encode_values
from slam.pose import FloatArray

TIME_WRAP: Final = 2**24 / 1000.0
"""Seconds after which the sensor's clock begins anew: 4.66 h."""
_ERROR_CODES: Final = 20
_BEYOND_REACH: Final = (0, 6, 16)
"""The errors that mean an object at 22 m, 5.7 m or 4096 mm: there is no echo within reach."""
_NO_ECHO, _ERRONEOUS = 0, 7


@dataclass(frozen=True, slots=True, eq=False)
class ScanData:
    """The answer to a measuring command."""

    request: Measure
    """As echoed: ``scans`` are left."""
    ranges: FloatArray
    """Metres, one for each cluster of steps; as REP-117 has it, inf is no echo and nan an erroneous reading."""
    time: float | None
    """The sensor's clock at step 0 of the turn, seconds modulo ``TIME_WRAP``; SCIP 1.1 says none."""


def encode_time(seconds: float) -> bytes:
    """Four characters."""
    return encode_values(np.array([round(seconds * 1000.0) % 2**24]), 4)


def decode_time(text: bytes) -> float:
    """Seconds; Damaged unless there are four characters."""
    if len(text) != 4:
        raise DecodeError(f"a time of {len(text)} characters")
    return int(decode_values(text, 4)[0]) / 1000.0


def encode_scan(scan: ScanData, status: str) -> Reply:
    """The sensor's answer. What the characters of the request cannot hold is sent as no echo."""
    data = data_lines(encode_values(_to_millimetres(scan.ranges, scan.request.width), scan.request.width))
    stamp = () if scan.time is None else (encode_time(scan.time),)
    return Reply(scan.request.encode(), status, (*stamp, *data))


def decode_scan(reply: Reply) -> ScanData:
    """The ranges in an answer; Damaged when it has none, or not as many as its echo says."""
    request = Measure.decode(reply.echo)
    stamped = request.letters != "G"
    if len(reply.lines) < 1 + stamped:
        raise DecodeError("no ranges")
    data = b"".join(reply.lines[stamped:])
    if reply.lines[stamped:] != data_lines(data):
        raise DecodeError("a line of ranges is not as long as it should be")
    values = decode_values(data, request.width)
    if len(values) != request.values:
        raise DecodeError(f"{len(values)} ranges where {request.values} were asked for")
    return ScanData(request, to_metres(values), decode_time(reply.lines[0]) if stamped else None)


def to_metres(values: IntArray) -> FloatArray:
    """Ranges of values (N,): inf is no echo, nan an erroneous reading."""
    ranges = np.where(values < _ERROR_CODES, np.nan, values / 1000.0)
    ranges[np.isin(values, _BEYOND_REACH)] = np.inf
    return ranges


def _to_millimetres(ranges: FloatArray, width: int) -> IntArray:
    finite = np.isfinite(ranges)
    values = np.where(np.isnan(ranges), _ERRONEOUS, _NO_ECHO)
    values[finite] = np.round(ranges[finite] * 1000.0).astype(np.int64)
    values[finite & (values < _ERROR_CODES)] = _ERRONEOUS
    values[values >= 64**width] = _NO_ECHO
    return values
