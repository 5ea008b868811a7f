"""What a noisy line lets through: ``python -m tests.noisy_line [PACKETS]`` from the top of the tree.

One byte in a hundred is damaged, scattered or in bursts of 64. A good message is one of which no byte was hit. The line
falls silent after each message, as those of both devices do.
"""

import sys
from contextlib import suppress
from dataclasses import dataclass
from math import hypot
from random import Random

import numpy as np

from hardware.arcos.commands import Command, CommandId
from hardware.arcos.packet import PacketDecoder, encode_packet
from hardware.arcos.sip import Sip, is_sip
from hardware.arcos.units import P3DX_SH
from hardware.base_odometry import PositionOdometry
from hardware.damaged import Damaged
from hardware.odometry_track import OdometryTrack
from hardware.scip.commands import Measure
from hardware.scip.frames import FrameDecoder
from hardware.scip.reply import find_reply
from hardware.scip.scan_data import ScanData, decode_scan, encode_scan
from hardware.wheel_scales import WheelScales

SHARE = 0.01


@dataclass
class Score:
    """Messages sent, of these unharmed, and received rightly and wrongly."""

    sent: int = 0
    good: int = 0
    right: int = 0
    wrong: int = 0


class Hail:
    """Damages one byte in a hundred, in runs of ``burst`` bytes."""

    def __init__(self, burst: int, seed: int) -> None:
        self._rng = Random(seed)
        self._burst = burst
        self._left = 0

    def on(self, data: bytes) -> bytes:
        """The bytes as they arrive."""
        arrived = bytearray(data)
        for at in range(len(arrived)):
            if self._left == 0 and self._rng.random() < SHARE / self._burst:
                self._left = self._burst
            if self._left:
                arrived[at] ^= self._rng.randrange(1, 256)
                self._left -= 1
        return bytes(arrived)


def hear_sips(count: int, burst: int, seed: int = 0) -> Score:
    """Reports of a robot that drives a circle; a pose is wrong when it is off by more than 5 mm."""
    score, hail, decoder, track = Score(), Hail(burst, seed), PacketDecoder(), OdometryTrack()
    odometry, heading, x, y = PositionOdometry(P3DX_SH, WheelScales(P3DX_SH.half_track), track), 0.0, 0.0, 0.0
    for k in range(count):
        sip = Sip(moving=True, x=x, y=y, theta=heading, left=0.25, right=0.35, fine_battery=12.6)
        wire = encode_packet(sip.encode(P3DX_SH))
        arrived = hail.on(wire)
        score.sent += 1
        score.good += arrived == wire
        for data in [*decoder.feed(arrived), *decoder.flush()]:
            with suppress(Damaged):
                if is_sip(data) and odometry.add(0.1 * k, Sip.decode(data, P3DX_SH)):
                    assert track.last is not None
                    pose = track.last[1]
                    off = hypot(pose.x - x, pose.y - y)
                    score.right += off < 0.005
                    score.wrong += off >= 0.005
        x, y = x + 0.03 * np.cos(heading), y + 0.03 * np.sin(heading)
        heading = (heading + 0.028 + np.pi) % (2 * np.pi) - np.pi
    return score


def hear_scans(count: int, burst: int, seed: int = 0) -> Score:
    """Full scans with ranges of their own."""
    score, hail, decoder, rng = Score(), Hail(burst, seed), FrameDecoder(), np.random.default_rng(seed)
    request = Measure("MD", 44, 725)
    sent: dict[float, np.ndarray] = {}
    for k in range(count):
        time, ranges = k / 10.0, np.round(rng.uniform(0.02, 5.6, request.values), 3)
        sent = {t: r for t, r in sent.items() if t > time - 1.0} | {time: ranges}
        wire = encode_scan(ScanData(request, ranges, time), "99").encode()
        arrived = hail.on(wire)
        score.sent += 1
        score.good += arrived == wire
        frames = decoder.feed(arrived)
        decoder.flush()
        for lines in frames:
            reply = find_reply(lines)
            if reply is None:
                continue
            with suppress(Damaged):
                scan = decode_scan(reply)
                right = scan.time in sent and np.array_equal(scan.ranges, sent[scan.time])
                score.right += right
                score.wrong += not right
    return score


def hear_commands(count: int, burst: int, seed: int = 0) -> Score:
    """Velocities on their way to a robot."""
    score, hail, decoder, rng = Score(), Hail(burst, seed), PacketDecoder(), Random(seed)
    for _ in range(count):
        command = Command(CommandId.VEL, rng.randrange(-1200, 1200))
        wire = encode_packet(command.encode())
        arrived = hail.on(wire)
        score.sent += 1
        score.good += arrived == wire
        for data in [*decoder.feed(arrived), *decoder.flush()]:
            with suppress(Damaged):
                right = Command.decode(data) == command
                score.right += right
                score.wrong += not right and data[0] == CommandId.VEL
    return score


def main() -> None:
    """All of it."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    for hear in (hear_sips, hear_scans, hear_commands):
        for burst in (1, 64):
            print(f"{hear.__name__} burst {burst}: {hear(count, burst)}")


if __name__ == "__main__":
    main()
