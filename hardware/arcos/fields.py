"""Little-endian fields in a row, as in the reports of a robot."""

import struct
from dataclasses import dataclass, field, fields
from typing import Any

from hardware import DecodeError


@dataclass(frozen=True, slots=True)
class Field:
    """One field: the name of its attribute, its ``struct`` code, and the SI value of one unit."""

    name: str
    code: str
    unit: float = 1

    @property
    def size(self) -> int:
        """Size in bytes."""
        return struct.calcsize("<" + self.code)

    def encode(self, value: float) -> bytes:
        """Return the nearest value that the field can hold."""
        bits, signed = 8 * self.size, self.code.islower()
        low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
        return struct.pack("<" + self.code, max(low, min(high, round(value / self.unit))))

    def decode(self, data: bytes) -> float:
        """Return the value in SI units; a plain whole number where the unit is 1."""
        value: int = struct.unpack("<" + self.code, data)[0]
        return value if self.unit == 1 else value * self.unit


def number(code: str, unit: float = 1, optional: bool = False) -> Any:
    """Declare an attribute of a dataclass as a field: its ``struct`` code, and the SI value of one unit."""
    default = None if optional else 0 if unit == 1 else 0.0
    return field(default=default, metadata={"code": code, "unit": unit})


def number_fields(packet: type) -> tuple[Field, ...]:
    """Return the fields of the attributes that are declared as ``number``, in order."""
    return tuple(Field(f.name, **f.metadata) for f in fields(packet) if f.metadata)


class FieldReader:
    """Takes fields off the front of a packet's data."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    @property
    def left(self) -> int:
        """Number of bytes not yet taken."""
        return len(self._data)

    def take(self, field: Field) -> float:
        """Take the next field; DecodeError if the data end first."""
        if len(self._data) < field.size:
            raise DecodeError(f"{field.size} bytes expected where {len(self._data)} are left")
        head, self._data = self._data[: field.size], self._data[field.size :]
        return field.decode(head)

    def take_string(self) -> str:
        """Take the next string, without the NUL that ends it; Latin-1."""
        head, _, self._data = self._data.partition(b"\0")
        return head.decode("latin-1")
