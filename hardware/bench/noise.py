"""Benchmark of noise: the messages that get through a noisy wire, and the wrong ones among them."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import hypot
from typing import Final

import numpy as np

from hardware import DecodeError
from hardware.arcos.commands import Command, CommandId
from hardware.arcos.model import P3DX_SH
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.arcos.sip import Sip, is_sip
from hardware.base_odometry import PositionOdometry, WheelScales
from hardware.odometry_history import OdometryHistory
from hardware.scip.commands import ScanRequest
from hardware.scip.frames import FrameDecoder
from hardware.scip.partial_scans import partial_scans
from hardware.scip.scan_data import ScanData, encode_scan
from slam.pose import wrap_angle

_REQUEST: Final = ScanRequest("MD", 44, 725)
_REACH: Final = 5.6


@dataclass(frozen=True, slots=True)
class ByteDamage:
    """Corrupts a ``share`` of the bytes, in bursts of ``burst``: one bit per byte if ``bits``, else one or more."""

    share: float
    burst: int = 1
    bits: bool = False

    def apply(self, data: bytes, rng: np.random.Generator) -> bytes:
        """Return the bytes as they arrive."""
        begins = np.flatnonzero(rng.random(len(data) + self.burst - 1) < self.share / self.burst)
        hit = np.unique(begins[:, None] - np.arange(self.burst))
        hit = hit[(hit >= 0) & (hit < len(data))]
        flips = 1 << rng.integers(0, 8, len(hit)) if self.bits else rng.integers(1, 256, len(hit))
        arrived = np.frombuffer(data, np.uint8).copy()
        arrived[hit] ^= flips.astype(np.uint8)
        return arrived.tobytes()


@dataclass(slots=True)
class ReceptionCounts:
    """Counts of messages."""

    sent: int = 0
    unharmed: int = 0
    """Messages that no damage hit."""
    received: int = 0
    """Undamaged messages that were received."""
    wrong: int = 0
    """Number of wrong messages that were accepted; for scans, the number of wrong ranges that were accepted."""
    beams: float = 0.0
    """Share of all ranges of scans that were received correctly."""


def receive_sips(count: int, damage: ByteDamage, seed: int = 0) -> ReceptionCounts:
    """Receive reports of a robot that drives a circle, as the driver does; a pose that is 5 mm off is wrong."""
    counts, decoder, history, rng = ReceptionCounts(), PacketDecoder(), OdometryHistory(), np.random.default_rng(seed)
    odometry = PositionOdometry(P3DX_SH, WheelScales(P3DX_SH.half_track), history)
    odometry.add(-0.1, Sip(left=0.25, right=0.35))
    for k, (x, y, heading) in zip(range(count), _circle(), strict=False):
        sip = Sip(moving=True, x=x, y=y, theta=heading, left=0.25, right=0.35, fine_battery=12.6)
        arrived, unharmed = _sent(counts, encode_packet(sip.encode(P3DX_SH)), damage, rng)
        right = 0
        for data in [*decoder.feed(arrived), *decoder.flush()]:
            with suppress(DecodeError):
                if is_sip(data) and odometry.add(0.1 * k, Sip.decode(data, P3DX_SH)):
                    assert history.last is not None
                    off = hypot(history.last[1].x - x, history.last[1].y - y)
                    right, counts.wrong = right + (off < 0.005), counts.wrong + (off >= 0.005)
        counts.received += unharmed and right > 0
    return counts


def receive_commands(count: int, damage: ByteDamage, seed: int = 0) -> ReceptionCounts:
    """Receive velocities, as the robot does."""
    counts, decoder, rng = ReceptionCounts(), PacketDecoder(), np.random.default_rng(seed)
    for _ in range(count):
        command = Command(CommandId.VEL, int(rng.integers(-1200, 1200)))
        arrived, unharmed = _sent(counts, encode_packet(command.encode()), damage, rng)
        decoded = []
        for data in [*decoder.feed(arrived), *decoder.flush()]:
            with suppress(DecodeError):
                decoded.append(Command.decode(data))
        counts.received += unharmed and command in decoded
        counts.wrong += sum(other != command and other.id == CommandId.VEL for other in decoded)
    return counts


def receive_scans(count: int, damage: ByteDamage, seed: int = 0) -> ReceptionCounts:
    """Receive full scans, each with other ranges, as the driver does."""
    counts, decoder, rng = ReceptionCounts(), FrameDecoder(), np.random.default_rng(seed)
    for k in range(count):
        ranges = np.round(rng.uniform(0.02, _REACH, _REQUEST.values), 3)
        arrived, unharmed = _sent(counts, encode_scan(ScanData(_REQUEST, ranges, k / 10.0), "99").encode(), damage, rng)
        frames = decoder.feed(arrived)
        decoder.flush()
        for scan in [scan for lines in frames for scan in partial_scans(lines, _REACH) if scan.request == _REQUEST]:
            right = (scan.ranges == ranges) & (scan.time == k / 10.0)
            counts.received += unharmed and bool(right.all())
            counts.wrong += int(np.count_nonzero(~right & ~np.isnan(scan.ranges)))
            counts.beams += float(np.mean(right)) / count
    return counts


RECEIVERS: Final[dict[str, Callable[[int, ByteDamage], ReceptionCounts]]] = {
    "reports of the robot": receive_sips,
    "commands to the robot": receive_commands,
    "scans": receive_scans,
}


def _sent(counts: ReceptionCounts, wire: bytes, damage: ByteDamage, rng: np.random.Generator) -> tuple[bytes, bool]:
    """Count a message that is sent; return its bytes as they arrive, and True if none was damaged."""
    arrived = damage.apply(wire, rng)
    counts.sent += 1
    counts.unharmed += arrived == wire
    return arrived, arrived == wire


def _circle() -> Iterator[tuple[float, float, float]]:
    x = y = heading = 0.0
    while True:
        yield x, y, heading
        x, y = x + 0.03 * np.cos(heading), y + 0.03 * np.sin(heading)
        heading = wrap_angle(heading + 0.028)
