"""Ranges on the wire: a time stamp, and whole millimetres, where values below 20 are error codes."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from hardware import DecodeError
from hardware.scip.commands import ScanRequest
from hardware.scip.encoding import IntArray, decode_values, encode_values
from hardware.scip.reply import Reply, data_lines
from hardware.scip.time_stamp import decode_time, encode_time
from slam.pose import FloatArray

_ERROR_CODES: Final = 20
_BEYOND_REACH: Final = (0, 6, 16)
"""Error codes that mean no echo within range; by version of the sensor, its limit is 22 m, 5.7 m or 4096 mm."""
_NO_ECHO, _ERRONEOUS = 0, 7


@dataclass(frozen=True, slots=True, eq=False)
class ScanData:
    """The answer to a measuring command."""

    request: ScanRequest
    """The echoed request; its ``scans`` are those still to come."""
    ranges: FloatArray
    """Metres, one for each cluster of steps; inf is no echo and nan an erroneous reading (REP-117)."""
    time: float | None
    """Time stamp of step 0 of the turn, seconds of the sensor's clock; None in SCIP 1.1."""


def encode_scan(scan: ScanData, status: str) -> Reply:
    """Return the sensor's answer; ranges too long for the characters of the request are sent as no echo."""
    data = data_lines(encode_values(_to_millimetres(scan.ranges, scan.request.width), scan.request.width))
    stamp = () if scan.time is None else (encode_time(scan.time),)
    return Reply(scan.request.encode(), status, (*stamp, *data))


def decode_scan(reply: Reply) -> ScanData:
    """Read the ranges of an answer; DecodeError if their number differs from that in the echo."""
    request = ScanRequest.decode(reply.echo)
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
    """Return the ranges of values (N,): inf is no echo, nan an erroneous reading."""
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
