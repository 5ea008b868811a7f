"""The lines of a wire recording: a time, a port, what happened there, and the bytes in hexadecimal.

    # hopslam wire 1: seconds of a monotonic clock; 12345.678901 was 2026-11-27T09:30:00+00:00
    12345.678901 /dev/ttyACM0 = 19200
    12345.679213 /dev/ttyACM0 > 51540a
    12345.701002 /dev/ttyACM0 < 51540a3030500a0a
    12399.120000 /dev/ttyACM0 - the device is gone; was it unplugged?

``=`` is a port opened, or its bit rate changed; ``>`` goes to the device, ``<`` comes from it; ``-`` is a port closed,
or lost for that reason. Truncated lines and lines of any other form are skipped when the file is read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, cast
from urllib.parse import quote, unquote

from slam.errors import InputError

Kind = Literal["=", ">", "<", "-"]
HEADER: Final = "# hopslam wire 1"
LONGEST_LINE: Final = 1 << 20
"""Longest line, characters; a chunk has at most some thousand bytes."""
_LINE: Final = re.compile(r"(\d+\.\d+) (\S+) ([=><-]) ?(.*)\n")


@dataclass(frozen=True, slots=True)
class WireEvent:
    """Event at a port: ``data`` of ``>`` and ``<``, ``text`` of the others."""

    stamp: float
    """Time of the event on the file's clock, seconds."""
    port: str
    kind: Kind
    data: bytes = b""
    text: str = ""

    def line(self) -> str:
        """Return the line of the file."""
        content = self.data.hex() if self.kind in "><" else self.text.replace("\n", " ")
        return f"{self.stamp:.6f} {quote(self.port, safe='/:.@,+=-_~')} {self.kind} {content}\n"

    @classmethod
    def parse(cls, line: str) -> WireEvent | None:
        """Read a line; None if it is not an event."""
        found = _LINE.fullmatch(line)
        if found is None:
            return None
        stamp, port, kind, content = float(found[1]), unquote(found[2]), cast(Kind, found[3]), found[4]
        if kind not in "><":
            return cls(stamp, port, kind, text=content)
        try:
            return cls(stamp, port, kind, bytes.fromhex(content))
        except ValueError:
            return None


def read_wire(path: Path) -> Iterator[WireEvent]:
    """Read a recording line by line; InputError if the file cannot be read or is not a recording."""
    try:
        with path.open(encoding="ascii", errors="replace") as file:
            if not file.readline(LONGEST_LINE).startswith(HEADER):
                raise InputError(f"{path}: no wire recording; make one with: hopslam run ... --record-wire FILE")
            while line := file.readline(LONGEST_LINE):
                event = WireEvent.parse(line)
                if event is not None:
                    yield event
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
