"""Recovers the undamaged lines of scans with damaged lines.

The sum of a line has six bits. It always detects one damaged byte. Two damaged bytes are missed once in a thousand if
any byte may become any other, and once in thirty if one bit flips. So lines can be trusted only if the wire is not too
noisy: if more than an eighth of the lines is damaged, nothing is kept. Damage also comes in runs, whose ends reach into
the next line by a byte or two: the neighbours of a damaged line are dropped. ``hopslam bench hardware noise`` measures
the wrong ranges that remain.
"""

from collections.abc import Sequence
from contextlib import suppress
from itertools import takewhile
from math import inf
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hardware import DecodeError
from hardware.scip.commands import ScanRequest
from hardware.scip.encoding import check_sum, decode_values
from hardware.scip.frames import Lines
from hardware.scip.reply import DATA_LINE, data_lines, decode_reply, possible_replies
from hardware.scip.scan_data import ScanData, to_metres
from hardware.scip.time_stamp import decode_time

_MAX_DAMAGED: Final = 1 / 8
"""Largest share of the lines that may be damaged."""
_TOO_FAR: Final = 2.0
"""Ranges beyond this multiple of the sensor's range limit are damage that the line's sum has missed."""
_NOTHING: Final = b"0"

Mask = NDArray[np.bool_]


def partial_scans(lines: Lines, reach: float = inf) -> list[ScanData]:
    """Read the scans of MD or MS among the lines between two empty lines; ranges are nan where their lines are lost.

    There is mostly one; none if too little is left; two if the empty line between them was lost. Echo, status and time
    must be correct. ``reach`` is the sensor's, metres.
    """
    scans = []
    for answer in possible_replies(lines):
        with suppress(DecodeError):
            scans.append(_partial_scan(answer, reach))
    return scans


def _partial_scan(lines: Lines, reach: float) -> ScanData:
    head = decode_reply(lines[:3])
    request = ScanRequest.decode(head.echo)
    if head.status != "99" or not head.lines or request.values < 1:
        raise DecodeError("not a scan of MD or MS")
    blank = data_lines(_NOTHING * (request.values * request.width))
    texts = [_text(line) for line in _in_place(lines[3:], blank)]
    data = b"".join(empty if text is None else text for text, empty in zip(texts, blank, strict=True))
    values = decode_values(data, request.width)
    good = np.array([text is not None for text in texts])
    good[_line_of(np.flatnonzero(values > _TOO_FAR * reach * 1000.0), request.width)] = False
    if np.count_nonzero(~good) > _MAX_DAMAGED * len(good):
        raise DecodeError(f"{np.count_nonzero(~good)} of {len(good)} lines are damaged")
    believed = np.repeat(_without_neighbours(good), DATA_LINE)[: len(data)].reshape(-1, request.width).all(axis=1)
    return ScanData(request, np.where(believed, to_metres(values), np.nan), decode_time(head.lines[0]))


def _in_place(lines: Sequence[bytes], blank: Sequence[bytes]) -> list[bytes | None]:
    """Return the lines of the scan in order, with None for lines that cannot be assigned.

    Lines are assigned from both ends, up to the first one of the wrong length: a byte or a line end was lost or added
    there.
    """
    sizes = [len(line) + 1 for line in blank]
    front = _fitting(lines, sizes)
    if front == len(lines) == len(sizes):
        return list(lines)
    back = min(_fitting(lines[::-1], sizes[::-1]), len(lines) - front, len(sizes) - front)
    lost = len(sizes) - front - back
    return [*lines[:front], *[None] * lost, *lines[len(lines) - back :]]


def _fitting(lines: Sequence[bytes], sizes: Sequence[int]) -> int:
    """Count the leading lines that have these sizes."""
    return sum(1 for _ in takewhile(lambda pair: len(pair[0]) == pair[1], zip(lines, sizes, strict=False)))


def _text(line: bytes | None) -> bytes | None:
    with suppress(DecodeError):
        if line is not None:
            text = check_sum(line)
            decode_values(text, 1)
            return text
    return None


def _line_of(values: NDArray[np.intp], width: int) -> NDArray[np.intp]:
    """Return the lines in which these values begin, and those in which they end."""
    return np.unique([values * width // DATA_LINE, (values * width + width - 1) // DATA_LINE])


def _without_neighbours(good: Mask) -> Mask:
    """Keep the lines with good neighbours only; the ends of a scan count as good."""
    fenced = np.concatenate([[True], good, [True]])
    believed: Mask = fenced[:-2] & fenced[1:-1] & fenced[2:]
    return believed
