"""IOpac: digital and analogue inputs and outputs, all in one packet (Pioneer 3 Operations Manual, p. 41)."""

from dataclasses import dataclass
from typing import Final

IO_PACKET: Final = 0xF0
_INPUT_BYTES, _OUTPUT_BYTES = 4, 1


@dataclass(frozen=True, slots=True)
class IoReport:
    """Digital ports as bytes, one bit per input.

    Inputs of bumpers and infrared sensors are 1 while nothing is touched.
    """

    digital_in: int
    front_bumpers: int
    rear_bumpers: int
    infrared: int
    digital_out: int
    analog: tuple[int, ...]
    """Ten-bit readings, 0 to 1023 for 0 to 5 V: ports 0 to 7, then the battery."""

    def encode(self) -> bytes:
        """Return the data of the packet."""
        inputs = bytes([self.digital_in, self.front_bumpers, self.rear_bumpers, self.infrared])
        head = bytes([IO_PACKET, _INPUT_BYTES]) + inputs + bytes([_OUTPUT_BYTES, self.digital_out, len(self.analog)])
        return head + b"".join(reading.to_bytes(2, "little") for reading in self.analog)
