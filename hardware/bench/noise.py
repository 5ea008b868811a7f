"""What gets through a noisy wire, and what of it is wrong."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import hypot
from typing import Final

import numpy as np

from hardware.arcos.commands import Command, CommandId
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.arcos.sip import Sip, is_sip
from hardware.arcos.units import P3DX_SH
from hardware.base_odometry import PositionOdometry
from hardware.decode_error import DecodeError
from hardware.odometry_track import OdometryTrack
from hardware.scip.commands import Measure
from hardware.scip.frames import FrameDecoder
from hardware.scip.partial_scans import partial_scans
from hardware.scip.scan_data import ScanData, encode_scan
from hardware.wheel_scales import WheelScales
from slam.pose import wrap_angle

_REQUEST: Final = Measure("MD", 44, 725)
_REACH: Final = 5.6


@dataclass(frozen=True, slots=True)
class Hail:
    """Damages a ``share`` of the bytes, in runs of ``burst``; with ``bits`` one bit of each, else it becomes any other
    byte."""

    share: float
    burst: int = 1
    bits: bool = False

    def on(self, data: bytes, rng: np.random.Generator) -> bytes:
        """The bytes as they arrive."""
        begins = np.flatnonzero(rng.random(len(data) + self.burst - 1) < self.share / self.burst)
        hit = np.unique(begins[:, None] - np.arange(self.burst))
        hit = hit[(hit >= 0) & (hit < len(data))]
        flips = 1 << rng.integers(0, 8, len(hit)) if self.bits else rng.integers(1, 256, len(hit))
        arrived = np.frombuffer(data, np.uint8).copy()
        arrived[hit] ^= flips.astype(np.uint8)
        return arrived.tobytes()


@dataclass(slots=True)
class Score:
    """Messages sent, and how many of these were not hit; what was received: of those that were not hit, and wrongly."""

    sent: int = 0
    good: int = 0
    survived: int = 0
    wrong: int = 0
    """Messages of which anything was believed that was not sent; of scans, how many ranges."""
    beams: float = 0.0
    """Of scans, the share of all ranges that were received rightly."""


def hear_sips(count: int, hail: Hail, seed: int = 0) -> Score:
    """Reports of a robot that drives a circle, as the driver reads them; a pose is wrong where it is 5 mm off."""
    score, decoder, track, rng = Score(), PacketDecoder(), OdometryTrack(), np.random.default_rng(seed)
    odometry = PositionOdometry(P3DX_SH, WheelScales(P3DX_SH.half_track), track)
    odometry.add(-0.1, Sip(left=0.25, right=0.35))
    for k, (x, y, heading) in zip(range(count), _circle(), strict=False):
        sip = Sip(moving=True, x=x, y=y, theta=heading, left=0.25, right=0.35, fine_battery=12.6)
        arrived, unharmed = _sent(score, encode_packet(sip.encode(P3DX_SH)), hail, rng)
        right = 0
        for data in [*decoder.feed(arrived), *decoder.flush()]:
            with suppress(DecodeError):
                if is_sip(data) and odometry.add(0.1 * k, Sip.decode(data, P3DX_SH)):
                    assert track.last is not None
                    off = hypot(track.last[1].x - x, track.last[1].y - y)
                    right, score.wrong = right + (off < 0.005), score.wrong + (off >= 0.005)
        score.survived += unharmed and right > 0
    return score


def hear_commands(count: int, hail: Hail, seed: int = 0) -> Score:
    """Velocities on their way to a robot."""
    score, decoder, rng = Score(), PacketDecoder(), np.random.default_rng(seed)
    for _ in range(count):
        command = Command(CommandId.VEL, int(rng.integers(-1200, 1200)))
        arrived, unharmed = _sent(score, encode_packet(command.encode()), hail, rng)
        heard = []
        for data in [*decoder.feed(arrived), *decoder.flush()]:
            with suppress(DecodeError):
                heard.append(Command.decode(data))
        score.survived += unharmed and command in heard
        score.wrong += sum(other != command and other.id == CommandId.VEL for other in heard)
    return score


def hear_scans(count: int, hail: Hail, seed: int = 0) -> Score:
    """Full scans with ranges of their own, as the driver reads them."""
    score, decoder, rng = Score(), FrameDecoder(), np.random.default_rng(seed)
    for k in range(count):
        ranges = np.round(rng.uniform(0.02, _REACH, _REQUEST.values), 3)
        arrived, unharmed = _sent(score, encode_scan(ScanData(_REQUEST, ranges, k / 10.0), "99").encode(), hail, rng)
        frames = decoder.feed(arrived)
        decoder.flush()
        for scan in [scan for lines in frames for scan in partial_scans(lines, _REACH) if scan.request == _REQUEST]:
            right = (scan.ranges == ranges) & (scan.time == k / 10.0)
            score.survived += unharmed and bool(right.all())
            score.wrong += int(np.count_nonzero(~right & ~np.isnan(scan.ranges)))
            score.beams += float(np.mean(right)) / count
    return score


HEARERS: Final[dict[str, Callable[[int, Hail], Score]]] = {
    "reports of the robot": hear_sips,
    "commands to the robot": hear_commands,
    "scans": hear_scans,
}


def _sent(score: Score, wire: bytes, hail: Hail, rng: np.random.Generator) -> tuple[bytes, bool]:
    """What arrives of a message, after which the line falls silent, and whether that is all of it."""
    arrived = hail.on(wire, rng)
    score.sent += 1
    score.good += arrived == wire
    return arrived, arrived == wire


def _circle() -> Iterator[tuple[float, float, float]]:
    """Poses every 0.1 s."""
    x = y = heading = 0.0
    while True:
        yield x, y, heading
        x, y = x + 0.03 * np.cos(heading), y + 0.03 * np.sin(heading)
        heading = wrap_angle(heading + 0.028)
