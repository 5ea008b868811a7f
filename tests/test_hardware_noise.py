"""Damaged bytes on the wire: no wrong range is accepted, and undamaged scans arrive."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.bench.noise import RECEIVERS, ByteDamage, receive_scans
from hardware.scip.commands import ScanRequest
from hardware.scip.partial_scans import partial_scans
from hardware.scip.scan_data import ScanData, encode_scan

REQUEST = ScanRequest("MD", 44, 725)
RANGES = np.round(np.random.default_rng(1).uniform(0.02, 5.6, REQUEST.values), 3)
WIRE = tuple(encode_scan(ScanData(REQUEST, RANGES, 1.0), "99").encode()[:-2].split(b"\n"))
FIRST = 3
"""Lines before the ranges: echo, status, time."""


@pytest.mark.parametrize("damage", [ByteDamage(0.01), ByteDamage(0.01, 64), ByteDamage(0.01, 1, True)])
@pytest.mark.parametrize("name", RECEIVERS)
def test_no_damaged_scan_is_accepted(name: str, damage: ByteDamage) -> None:
    score = RECEIVERS[name](300, damage)
    assert score.wrong == 0
    assert score.received == score.unharmed


def test_damage_loses_only_the_beams_around_it() -> None:
    score = receive_scans(100, ByteDamage(0.01, 64))
    assert score.unharmed < 85
    assert score.beams > 0.85


def lost(*lines: bytes) -> np.ndarray:
    """Return which beams a scan of these lines lacks; check that the others are right."""
    (scan,) = partial_scans((*WIRE[:FIRST], *lines))
    beams = np.isnan(scan.ranges)
    assert np.array_equal(scan.ranges[~beams], RANGES[~beams])
    return np.flatnonzero(beams)


def beams_of(first: int, last: int) -> np.ndarray:
    """Return the beams that have at least one character in these lines of data."""
    return np.arange(first * 64 // 3, min(-(-(last + 1) * 64 // 3), REQUEST.values))


@given(st.integers(0, 31), st.integers(0, 63), st.integers(1, 255))
def test_a_damaged_byte_loses_its_line_and_neighbours(line: int, at: int, flip: int) -> None:
    lines = [*WIRE[FIRST:]]
    damaged = bytearray(lines[line])
    damaged[at % len(damaged)] ^= flip
    if 0x0A in damaged:
        return
    lines[line] = bytes(damaged)
    assert np.array_equal(lost(*lines), beams_of(max(line - 1, 0), min(line + 1, 31)))


@given(st.integers(1, 30), st.integers(1, 62))
def test_lost_and_doubled_bytes_lose_no_more(line: int, at: int) -> None:
    lines, text = WIRE[FIRST:], WIRE[FIRST + line]
    around = beams_of(line - 1, line + 1)
    assert np.array_equal(lost(*lines[:line], text[:at] + text[at + 1 :], *lines[line + 1 :]), around)
    assert np.array_equal(lost(*lines[:line], text[:at] + text[at - 1 :], *lines[line + 1 :]), around)
    assert np.array_equal(lost(*lines[:line], text[:at], text[at + 1 :], *lines[line + 1 :]), around)
    run_together = text + b"x" + lines[line + 1]
    assert np.array_equal(lost(*lines[:line], run_together, *lines[line + 2 :]), beams_of(line - 1, min(line + 2, 31)))


def test_too_much_damage_leaves_no_scan() -> None:
    lines = [b"x" * 65 if at < 5 else line for at, line in enumerate(WIRE[FIRST:])]
    assert partial_scans((*WIRE[:FIRST], *lines)) == []
    for at in range(FIRST):
        assert partial_scans((*WIRE[:at], WIRE[at][:-1] + b"~", *WIRE[at + 1 :])) == []


def test_a_range_beyond_any_reach_is_damage() -> None:
    far = RANGES.copy()
    far[100] = 200.0
    wire = encode_scan(ScanData(REQUEST, far, 1.0), "99").encode()[:-2].split(b"\n")
    (scan,) = partial_scans(tuple(wire), reach=5.6)
    assert np.array_equal(np.flatnonzero(np.isnan(scan.ranges)), beams_of(3, 5))
