"""Commands to an ARCOS robot: a number, and an argument of one of four forms."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from math import radians
from typing import Final

from hardware import DecodeError


class CommandId(IntEnum):
    """The commands (Pioneer 3 Operations Manual, p. 28 to 30; ArCommands.h).

    A robot without a connection takes 0, 1 and 2 for SYNC0, SYNC1 and SYNC2.
    """

    PULSE = 0
    OPEN = 1
    CLOSE = 2
    POLLING = 3
    ENABLE = 4
    SETA = 5
    SETV = 6
    SETO = 7
    MOVE = 8
    ROTATE = 9
    SETRV = 10
    VEL = 11
    HEAD = 12
    DHEAD = 13
    SAY = 15
    JOYREQUEST = 17
    CONFIG = 18
    ENCODER = 19
    RVEL = 21
    DCHEAD = 22
    SETRA = 23
    SONAR = 28
    STOP = 29
    DIGOUT = 30
    VEL2 = 32
    GRIPPER = 33
    ADSEL = 35
    GRIPPERVAL = 36
    GRIPREQUEST = 37
    GYROCALCW = 38
    GYROCALCCW = 39
    IOREQUEST = 40
    TTY2 = 42
    GETAUX = 43
    BUMPSTALL = 44
    TCM2 = 45
    JOYDRIVE = 47
    SONARCYCLE = 48
    HOSTBAUD = 50
    AUX1BAUD = 51
    AUX2BAUD = 52
    AUX3BAUD = 53
    E_STOP = 55
    E_STALL = 56
    E_STOP_OLD = 57
    GYROREQUEST = 58
    LCDWRITE = 59
    TTY4 = 60
    GETAUX3 = 61
    BATTERYINFO = 62
    TTY3 = 66
    GETAUX2 = 67
    CHARGE = 68
    ROTKP = 82
    ROTKV = 83
    ROTKI = 84
    TRANSKP = 85
    TRANSKV = 86
    TRANSKI = 87
    REVCOUNT = 88
    DRIFTFACTOR = 89
    SOUNDTOG = 92
    TICKSMM = 93
    BATTEST = 250
    RESET = 253
    MAINTENANCE = 255


_IN_MILLIMETRES: Final[tuple[int, ...]] = (CommandId.SETA, CommandId.SETV, CommandId.MOVE, CommandId.VEL)
_IN_DEGREES: Final[tuple[int, ...]] = (
    CommandId.ROTATE, CommandId.SETRV, CommandId.HEAD, CommandId.DHEAD, CommandId.RVEL, CommandId.SETRA,
)  # fmt: skip
SI_PER_UNIT: Final[dict[int, float]] = dict.fromkeys(_IN_MILLIMETRES, 0.001) | dict.fromkeys(_IN_DEGREES, radians(1.0))
"""SI value of one unit of the argument: the wire has whole mm and degrees."""

BAUDS: Final = (9600, 19200, 38400, 57600, 115200)
"""The argument of HOSTBAUD is an index into these."""

VEL2_UNIT: Final = 0.020
"""m/s (Vel2Divisor of p3dx.p)."""
_INT, _NEGATIVE, _STRING = 0x3B, 0x1B, 0x2B


@dataclass(frozen=True, slots=True)
class Command:
    """One command: no argument, a whole number within +-65535, or a string of bytes."""

    id: int
    argument: int | bytes | None = None

    @classmethod
    def of(cls, id: CommandId, quantity: float) -> Command:
        """Make the command whose argument is nearest to a quantity in SI units."""
        return cls(id, max(-32767, min(32767, round(quantity / SI_PER_UNIT[id]))))

    @property
    def quantity(self) -> float:
        """Argument in SI units; DecodeError for a command that has none."""
        scale = SI_PER_UNIT.get(self.id)
        if scale is None or not isinstance(self.argument, int):
            raise DecodeError(f"command {self.id} with {self.argument!r} has no quantity")
        return self.argument * scale

    def encode(self) -> bytes:
        """Return the data of the command's packet."""
        if self.argument is None:
            return bytes([self.id])
        if isinstance(self.argument, bytes):
            return bytes([self.id, _STRING, len(self.argument)]) + self.argument
        kind = _INT if self.argument >= 0 else _NEGATIVE
        return bytes([self.id, kind]) + abs(self.argument).to_bytes(2, "little")

    @classmethod
    def decode(cls, data: bytes) -> Command:
        """Read a command from a packet's data; DecodeError for an unknown form.

        Player cuts SETO off after the type of its argument; it is read as SETO without an argument.
        """
        if len(data) <= 2:
            return cls(data[0])
        kind, rest = data[1], data[2:]
        if kind == _STRING and len(rest) > rest[0]:
            return cls(data[0], rest[1 : 1 + rest[0]])  # Aria appends a NUL that the length does not count
        if kind in (_INT, _NEGATIVE) and len(rest) >= 2:
            value = int.from_bytes(rest[:2], "little")
            return cls(data[0], value if kind == _INT else -value)
        raise DecodeError(f"argument of kind {kind:#04x} with {len(rest)} bytes")


def encode_vel2(left: float, right: float) -> Command:
    """Make VEL2 as Aria sends it: two signed bytes in one word, the left one high; m/s, in steps of 20 mm/s."""
    left_byte, right_byte = (max(-128, min(127, round(speed / VEL2_UNIT))) & 0xFF for speed in (left, right))
    word = (left_byte << 8) | right_byte
    return Command(CommandId.VEL2, word if word < 0x8000 else word - 0x10000)


def decode_vel2(argument: int) -> tuple[float, float]:
    """Return the speeds of the left and the right wheel, m/s, from Aria's signed word or Player's raw one."""
    word = argument & 0xFFFF
    left, right = (byte - 256 if byte > 127 else byte for byte in (word >> 8, word & 0xFF))
    return left * VEL2_UNIT, right * VEL2_UNIT
