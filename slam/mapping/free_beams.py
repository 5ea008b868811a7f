"""The beams of a scan with their free ranges, and a search for the beam towards a position, compiled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.pose import FloatArray
from slam.scan import BEARING, COS, SIN, LaserScan

CORRECTIONS = 3  # iterations that lead from the beam of an even fan to the beam of the deskewed one
MAX_SECTORS = 64
"""Sectors of the full turn, each with the longest free range of its beams."""
BEAMS_PER_SECTOR = 4  # at an even spacing over the full turn, so that no sector is empty


class FreeBeams(NamedTuple):
    """Beams of a scan, each with the range over which it was certainly free."""

    ranges: FloatArray
    """(N,): free range, metres; 0 for an error or a reading that is too near."""
    echoes: NDArray[np.bool_]
    """(N,): True if the beam has an echo."""
    fan: FloatArray
    """(3, N), see scan.py; a deskewed scan is uneven, so that a beam is searched in it."""
    angle_min: float
    angle_increment: float
    """Step of the fan before it was deskewed, for the start of the search."""
    farthest: FloatArray
    """(S,): the greatest range in each sector and its two neighbours, for a fast check of what is hidden."""


def free_beams(scan: LaserScan, no_echo_reach: float) -> FreeBeams:
    """Return the free ranges of a scan; a beam without an echo counts as free for ``no_echo_reach`` metres."""
    fan = scan.fan
    ranges, echoes = _free_ranges(scan.ranges, scan.range_min, scan.range_max, no_echo_reach)
    return FreeBeams(ranges, echoes, fan, scan.angle_min, scan.angle_increment, _farthest(ranges, fan))


@compiled
def _free_ranges(
    readings: FloatArray, range_min: float, range_max: float, no_echo_reach: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return free ranges and echoes of the readings (N,), for a sensor with these range limits."""
    ranges, echoes = np.zeros(len(readings)), np.zeros(len(readings), np.bool_)
    for j in range(len(readings)):
        if readings[j] == np.inf:
            ranges[j] = min(no_echo_reach, range_max)
        elif range_min <= readings[j] <= range_max:
            ranges[j], echoes[j] = readings[j], True
    return ranges, echoes


@compiled
def _farthest(ranges: FloatArray, fan: FloatArray) -> FloatArray:
    sectors = max(min(MAX_SECTORS, len(ranges) // BEAMS_PER_SECTOR), 1)
    farthest = np.zeros(sectors)
    for j in range(len(ranges)):
        at = _sector(fan[COS, j], fan[SIN, j], sectors)
        for sector in (at - 1, at, (at + 1) % sectors):
            farthest[sector] = max(farthest[sector], ranges[j])
    return farthest


@compiled_on_views
def _sector(x: float, y: float, sectors: int) -> int:
    """Return the sector of a direction, without trigonometry; sectors of one quarter turn differ a little in width."""
    part = y / (abs(x) + abs(y))
    turn = part if x >= 0.0 else 2.0 - part
    return int((turn + 1.0) * 0.25 * sectors) % sectors


@compiled_on_views
def is_hidden(farthest: FloatArray, x: float, y: float, distance: float) -> bool:
    """Return True if no beam towards (x, y), sensor frame, was free for this distance; a fast first check."""
    return bool(farthest[_sector(x, y, len(farthest))] <= distance)


@compiled_on_views
def beam_towards(beams: FreeBeams, pose: FloatArray, dx: float, dy: float) -> int:
    """Return the beam from ``pose`` (3,) nearest to (dx, dy), map frame; below 0, or N and more, for none.

    The beams of a deskewed scan are nearly even: the offset at the corresponding beam of an even fan leads to the
    nearest one.
    """
    heading = np.arctan2(dy, dx) - pose[2]
    bearing = heading - beams.angle_min
    bearing -= 2.0 * np.pi * np.floor(bearing / (2.0 * np.pi))
    j = int(np.floor(bearing / beams.angle_increment + 0.5))
    for _ in range(CORRECTIONS):
        if not 0 <= j < len(beams.ranges):
            break
        off = heading - beams.fan[BEARING, j]
        off -= 2.0 * np.pi * np.floor(off / (2.0 * np.pi) + 0.5)
        step = int(np.floor(off / beams.angle_increment + 0.5))
        if step == 0:
            break
        j += step
    return j
