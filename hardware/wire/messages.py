"""Cuts one direction of a recorded port into messages of any protocol, without losing a byte."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

from hardware.arcos.packet import HEADER, MAX_DATA, checksum
from hardware.ldrobot import HEADER as LD_HEADER
from hardware.ldrobot import SIZE, crc8

Protocol = Literal["arcos", "ldrobot", "scip", "none"]
_TEXT: Final = re.compile(rb"[\n\r\x20-\x7e]*")
_LONGEST_TEXT: Final = 8192


@dataclass(frozen=True, slots=True)
class WireMessage:
    """Bytes of one message: the data of an ARCOS packet, a packet of LDROBOT, the text of SCIP, or unknown bytes."""

    protocol: Protocol
    data: bytes


class MessageSplitter:
    """Takes chunks of one direction.

    ``end`` ends a message of SCIP: an empty line from the sensor, a line feed to it.
    """

    def __init__(self, end: bytes) -> None:
        self._end = end
        self._buffer = b""

    def feed(self, chunk: bytes) -> Iterator[WireMessage]:
        """Take bytes, and yield the messages that are now complete."""
        self._buffer += chunk
        while self._buffer:
            message, size = self._first()
            if not size:
                return
            self._buffer = self._buffer[size:]
            if message.data.strip(b"\r\n"):
                yield message

    def flush(self) -> Iterator[WireMessage]:
        """Yield incomplete messages after the line fell silent."""
        left, self._buffer = self._buffer, b""
        if left.strip(b"\r\n"):
            yield WireMessage("none", left)

    def _first(self) -> tuple[WireMessage, int]:
        """Return the first message and the number of its bytes; 0 if it is not complete yet."""
        if self._buffer.startswith(HEADER) or self._buffer == HEADER[:1]:
            return self._packet()
        if self._buffer.startswith(LD_HEADER):
            return self._points()
        text = _TEXT.match(self._buffer)
        return self._text(text.group()) if text and text.group() else self._neither()

    def _packet(self) -> tuple[WireMessage, int]:
        buffer, whole = self._buffer, 0
        if len(buffer) > 2:
            if not 3 <= buffer[2] <= MAX_DATA + 2:
                return self._neither()
            whole = buffer[2] + 3
        if not whole or len(buffer) < whole:
            return WireMessage("arcos", buffer), 0
        data, tail = buffer[3 : whole - 2], buffer[whole - 2 : whole]
        return (WireMessage("arcos", data), whole) if checksum(data) == int.from_bytes(tail, "big") else self._neither()

    def _points(self) -> tuple[WireMessage, int]:
        packet = self._buffer[:SIZE]
        if len(packet) < SIZE:
            return WireMessage("ldrobot", packet), 0
        return (WireMessage("ldrobot", packet), SIZE) if crc8(packet[:-1]) == packet[-1] else self._neither()

    def _text(self, text: bytes) -> tuple[WireMessage, int]:
        leading = len(text) - len(text.lstrip(b"\n"))
        end = text.find(self._end, leading)
        if end >= 0:
            return WireMessage("scip", text[leading:end]), end + len(self._end)
        if len(text) < len(self._buffer) or len(text) > _LONGEST_TEXT:
            return WireMessage("none", text), len(text)
        return WireMessage("scip", text), leading

    def _neither(self) -> tuple[WireMessage, int]:
        """Return the bytes before the next possible start of a packet."""
        starts = [place for header in (HEADER, LD_HEADER) if (place := self._buffer.find(header, 1)) > 0]
        end = min(starts, default=len(self._buffer) - (len(self._buffer) > 1 and self._buffer.endswith(HEADER[:1])))
        return WireMessage("none", self._buffer[:end]), end
