"""The one-way protocol of LDROBOT's lidars LD06, LD19 and STL-19P: packets of twelve points, sent without being asked.

``54 2C | speed | first angle | 12 x (mm, intensity) | last angle | ms | CRC``, little-endian, 47 bytes at 230400 baud.
Angles run clockwise from ahead. Source: LD19 Development Manual V2.3, LDROBOT.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from math import pi, radians
from typing import Final

import numpy as np

from hardware import DecodeError
from slam.pose import FloatArray

BAUD: Final = 230_400
POINTS: Final = 12
TIME_WRAP: Final = 30.0
"""Seconds after which the time stamps wrap."""
HEADER: Final = b"\x54\x2c"
_LAYOUT: Final = struct.Struct("<2sHH" + "HB" * POINTS + "HHB")
SIZE: Final = _LAYOUT.size
_POLYNOMIAL: Final = 0x4D
_HUNDREDTH: Final = radians(0.01)
"""Unit of angles on the wire, radians: a hundredth of a degree."""
_TURN: Final = 36_000
"""A full turn in that unit."""


def _crc_of_byte(byte: int) -> int:
    for _ in range(8):
        byte = (byte << 1 ^ (_POLYNOMIAL if byte & 0x80 else 0)) & 0xFF
    return byte


_CRC_TABLE: Final = bytes(_crc_of_byte(byte) for byte in range(256))


def crc8(data: bytes) -> int:
    """Return the CRC of eight bits, polynomial 0x4D, from 0."""
    crc = 0
    for byte in data:
        crc = _CRC_TABLE[crc ^ byte]
    return crc


@dataclass(frozen=True, slots=True, eq=False)
class LdPacket:
    """Twelve points in order; radians, metres, seconds."""

    speed: float
    """rad/s."""
    first: float
    """Angle of the first point, clockwise from ahead, 0 to 2 pi."""
    last: float
    """Angle of the last point, not less than ``first``: it may exceed a full turn."""
    ranges: FloatArray
    """(12,); inf without an echo."""
    intensities: tuple[int, ...]
    time: float
    """Time of the last point by the sensor's clock."""

    @property
    def angles(self) -> FloatArray:
        """Angles of the points (12,), evenly spaced as in the manual."""
        return np.linspace(self.first, self.last, POINTS)

    def encode(self) -> bytes:
        """Return the packet."""
        millimetres = np.where(np.isfinite(self.ranges), np.round(1000.0 * self.ranges), 0.0).astype(int)
        points = (number for point in zip(millimetres.tolist(), self.intensities, strict=True) for number in point)
        first, last = (round(angle / _HUNDREDTH) % _TURN for angle in (self.first, self.last))
        speed, time = round(self.speed / radians(1.0)), int(1000.0 * self.time) % round(1000.0 * TIME_WRAP)
        body = _LAYOUT.pack(HEADER, speed, first, *points, last, time, 0)[:-1]
        return body + bytes([crc8(body)])

    @classmethod
    def decode(cls, packet: bytes) -> LdPacket:
        """Read a packet; DecodeError for another or a damaged packet."""
        if len(packet) != SIZE or packet[:2] != HEADER:
            raise DecodeError(f"{len(packet)} bytes that are not a packet of twelve points")
        if crc8(packet[:-1]) != packet[-1]:
            raise DecodeError("wrong CRC")
        _, speed, first, *points, last, time, _ = _LAYOUT.unpack(packet)
        metres = np.array(points[::2], np.float64) / 1000.0
        begin = first * _HUNDREDTH
        span = (last - first) % _TURN * _HUNDREDTH
        if not (0 < speed and span < pi):
            raise DecodeError("angles that cannot be")
        ranges = np.where(metres > 0.0, metres, np.inf)
        return cls(radians(speed), begin, begin + span, ranges, tuple(points[1::2]), time / 1000.0)


class LdDecoder:
    """Finds packets in a stream that arrives in chunks; damaged ones are dropped."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> list[LdPacket]:
        """Take bytes, and return the packets that are now complete."""
        self._buffer += data
        packets = []
        while (start := self._buffer.find(HEADER)) >= 0 and len(self._buffer) >= start + SIZE:
            try:
                packets.append(LdPacket.decode(self._buffer[start : start + SIZE]))
                start += SIZE
            except DecodeError:
                start += 1
            self._buffer = self._buffer[start:]
        if start < 0:
            self._buffer = self._buffer[-1:]
        return packets
