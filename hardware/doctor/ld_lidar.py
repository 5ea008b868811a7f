"""Finds LDROBOT's lidars, which send without being asked."""

import time
from contextlib import closing
from math import pi
from typing import Final

from hardware.doctor.finding import Finding
from hardware.ldrobot import BAUD, LdDecoder
from hardware.lidars.ld_turns import TurnCollector
from hardware.serial_port import NoDevice, SerialPort
from hardware.wire.session import WireSession
from slam.lidars import LD19

_LISTENING: Final = 0.5
"""Seconds: two turns at 5 Hz."""


def examine_ld_lidar(port: str, _: int, wire: WireSession | None) -> Finding:
    """Listen without writing; NoDevice if no such lidar sends."""
    decoder, packets = LdDecoder(), []
    with closing(SerialPort(port, BAUD, wire)) as line:
        until = time.monotonic() + _LISTENING
        while (left := until - time.monotonic()) > 0.0:
            packets += decoder.feed(line.read(left))
    if not packets:
        raise NoDevice(f"{port}: no lidar of LDROBOT talks at {BAUD} baud")
    turns, reach = TurnCollector(), LD19.lidar
    scans = [turn.scan(reach.range_min, reach.range_max) for p in packets if (turn := turns.add(p, p.time)) is not None]
    words = f"lidar of LDROBOT's LD series (LD06, LD19, STL-19P), {packets[-1].speed / (2.0 * pi):.1f} scans a second"
    if scans:
        words += f" of {len(scans[0].ranges)} beams, {int(scans[0].echoes.sum())} with an echo"
    return Finding(port, f"{words}; set lidar.model=ld19", scan=scans[0] if scans else None, model="ld19")
