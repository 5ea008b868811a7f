"""The answer to SYNC2: who the robot is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from hardware.decode_error import DecodeError

SYNC2: Final = 2


@dataclass(frozen=True, slots=True)
class Identity:
    """The three strings, of at most 19 ASCII characters each (Player keeps them in char[20])."""

    name: str
    robot_class: str
    subclass: str

    def encode(self) -> bytes:
        """The data of the packet."""
        strings = (self.name, self.robot_class, self.subclass)
        return bytes([SYNC2]) + b"".join(text.encode("ascii") + b"\0" for text in strings)

    @classmethod
    def decode(cls, data: bytes) -> Identity:
        """From the data of a packet; Damaged when it is another one."""
        strings = data[1:].split(b"\0")
        if data[0] != SYNC2 or len(strings) < 3 or not data.isascii():
            raise DecodeError("not the three strings that answer SYNC2")
        return cls(*(text.decode("ascii") for text in strings[:3]))
