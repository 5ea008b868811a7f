"""Framing: ``FA FB | count | data | checksum``, where count is the length of data and checksum."""

from collections import deque
from typing import Final

HEADER: Final = b"\xfa\xfb"
MAX_DATA: Final = 195
"""Bytes of data in the longest packet, which is 200 bytes long."""

_REFUSED: Final = 8


def checksum(data: bytes) -> int:
    """Sum the data as big-endian words, and xor an odd last byte (ArRobotPacket::calcCheckSum)."""
    even = len(data) & ~1
    total = (sum(data[0:even:2]) << 8) + sum(data[1:even:2])
    return (total & 0xFFFF) ^ (data[-1] if len(data) & 1 else 0)


def encode_packet(data: bytes) -> bytes:
    """Make the packet of these data, 1 to MAX_DATA bytes."""
    if not 1 <= len(data) <= MAX_DATA:
        raise ValueError(f"a packet holds 1 to {MAX_DATA} bytes of data, not {len(data)}")
    return HEADER + bytes([len(data) + 2]) + data + checksum(data).to_bytes(2, "big")


class PacketDecoder:
    """Finds packets in a stream that arrives in chunks, with other bytes between them.

    After damage it looks for the next header inside the supposed packet, so that only damaged packets are lost. Between
    two calls it holds less than one packet.
    """

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.refused: deque[bytes] = deque(maxlen=_REFUSED)
        """Data of the newest packets whose checksums were wrong."""

    @property
    def pending(self) -> bool:
        """True while a packet has begun and is not yet complete."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[bytes]:
        """Take bytes, and return the data of each packet that is now complete."""
        self._buffer += data
        return self._whole()

    def flush(self) -> list[bytes]:
        """Give up an incomplete packet after the line fell silent, and return the packets found behind its header.

        Otherwise a damaged length byte would hold back the packets after it.
        """
        packets = []
        while self._buffer:
            del self._buffer[:1]
            packets += self._whole()
        return packets

    def _whole(self) -> list[bytes]:
        packets = []
        while self._seek():
            size = self._buffer[2] + 3
            if len(self._buffer) < size:
                break
            data, tail = bytes(self._buffer[3 : size - 2]), self._buffer[size - 2 : size]
            if checksum(data) == int.from_bytes(tail, "big"):
                packets.append(data)
                del self._buffer[:size]
            else:
                self.refused.append(data)
                del self._buffer[:1]
        return packets

    def _seek(self) -> bool:
        """Drop bytes that cannot begin a packet, and return True once header and length are there."""
        while (start := self._buffer.find(HEADER)) >= 0:
            del self._buffer[:start]
            if len(self._buffer) < 3:
                return False
            if 3 <= self._buffer[2] <= MAX_DATA + 2:
                return True
            del self._buffer[:1]
        del self._buffer[: len(self._buffer) - self._buffer.endswith(HEADER[:1])]
        return False
