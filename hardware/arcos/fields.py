"""Little-endian fields one after another, as the reports of a robot have them."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from hardware.decode_error import DecodeError


@dataclass(frozen=True, slots=True)
class Field:
    """One field: its attribute's name, its code in ``struct``, and what one unit of it is in SI units."""

    name: str
    code: str
    unit: float = 1

    @property
    def size(self) -> int:
        """Bytes."""
        return struct.calcsize("<" + self.code)

    def encode(self, value: float) -> bytes:
        """The nearest value that the field can hold."""
        bits, signed = 8 * self.size, self.code.islower()
        low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
        return struct.pack("<" + self.code, max(low, min(high, round(value / self.unit))))

    def decode(self, data: bytes) -> float:
        """The value in SI units; a plain whole number where the unit is 1."""
        value: int = struct.unpack("<" + self.code, data)[0]
        return value if self.unit == 1 else value * self.unit


class FieldReader:
    """Takes fields off the front of a packet's data."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    @property
    def left(self) -> int:
        """Bytes not yet taken."""
        return len(self._data)

    def take(self, field: Field) -> float:
        """The next field; Damaged when the data end before it does."""
        return field.decode(self.take_bytes(field.size))

    def take_bytes(self, size: int) -> bytes:
        """The next ``size`` bytes; Damaged when there are fewer."""
        if len(self._data) < size:
            raise DecodeError(f"{size} bytes expected where {len(self._data)} are left")
        head, self._data = self._data[:size], self._data[size:]
        return head

    def take_string(self) -> str:
        """The next string, without the NUL that ends it; Latin-1."""
        head, _, self._data = self._data.partition(b"\0")
        return head.decode("latin-1")
