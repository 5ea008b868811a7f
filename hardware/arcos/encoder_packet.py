"""ENCODERpac: the travel of both wheels, far finer than the position in a SIP."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from hardware import DecodeError
from hardware.arcos.fields import Field, FieldReader

ENCODER_PACKET: Final = 0x90
_TICKS: Final = Field("ticks", "i")
_WRAP: Final = 1 << 32


@dataclass(frozen=True, slots=True)
class WheelTravel:
    """Metres that the wheels have rolled, modulo ``travel_wrap``."""

    left: float
    right: float

    def encode(self, ticks_per_metre: float) -> bytes:
        """Return the data of the packet."""
        ticks = [round(metres * ticks_per_metre) % _WRAP for metres in (self.left, self.right)]
        return bytes([ENCODER_PACKET]) + b"".join(count.to_bytes(4, "little") for count in ticks)

    @classmethod
    def decode(cls, data: bytes, ticks_per_metre: float) -> WheelTravel:
        """Read the data of a packet; DecodeError for another packet."""
        if data[0] != ENCODER_PACKET:
            raise DecodeError(f"packet {data[0]:#04x} has no encoders")
        reader = FieldReader(data[1:])
        return cls(reader.take(_TICKS) / ticks_per_metre, reader.take(_TICKS) / ticks_per_metre)


def travel_wrap(ticks_per_metre: float) -> float:
    """Return the metres after which the counts of 32 bits wrap."""
    return _WRAP / ticks_per_metre
