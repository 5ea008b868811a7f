"""An auxiliary serial port of the emulated P3-DX, with or without a device."""

from typing import Final

from hardware.arcos.packet import encode_packet

SERAUX_PACKETS: Final = (0xB0, 0xB8, 0xC8)
"""SERAUXpac, SERAUX2pac and SERAUX3pac."""
_ROOM: Final = 253
"""Bytes from the device that the port keeps."""
_MAX_DATA: Final = 194
"""Bytes that one packet has room for."""


class AuxPort:
    """Carries bytes between the client and a device at AUX1, AUX2 or AUX3.

    TTY sends to the device; GETAUX waits until a number of bytes has come from it, and then sends them in one packet.
    """

    def __init__(self, packet_id: int) -> None:
        self._packet_id = packet_id
        self._waiting = b""
        self._wanted = 0
        self.sent = b""
        """Bytes that the client has sent to the device."""

    def send(self, data: bytes) -> None:
        """Pass bytes on to the device: TTY2, TTY3, TTY4."""
        self.sent += data

    def put(self, data: bytes) -> None:
        """Receive bytes from the device; bytes that do not fit are lost."""
        self._waiting = (self._waiting + data)[:_ROOM]

    def request(self, count: int) -> None:
        """Wait for ``count`` bytes; 0 drops the bytes received so far: GETAUX, GETAUX2, GETAUX3."""
        self._wanted = min(count, _MAX_DATA)
        if count == 0:
            self._waiting = b""

    def packet(self) -> bytes:
        """Return the packet with the requested bytes, or nothing until they have come."""
        if not self._wanted or len(self._waiting) < self._wanted:
            return b""
        data, self._waiting = self._waiting[: self._wanted], self._waiting[self._wanted :]
        self._wanted = 0
        return encode_packet(bytes([self._packet_id]) + data)
