"""Commands to the sensor: two letters, numbers of fixed width, and a line feed."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from hardware import DecodeError

BAUDS: Final = (19200, 38400, 57600, 115200, 250000, 500000, 750000)
"""The bit rates of SS."""
TO_SCIP2: Final = "SCIP2.0"
_CONTINUOUS: Final = re.compile(r"(MD|MS)(\d{4})(\d{4})(\d\d)(\d)(\d\d)")
_LATEST: Final = re.compile(r"(GD|GS)(\d{4})(\d{4})(\d\d)")
_OLD: Final = re.compile(r"G(\d{3})(\d{3})(\d\d)")
_NOTE: Final = re.compile(r";[A-Za-z0-9 ._+@]{0,16}")
"""Text that a client may append to any command, to recognise the answer."""
_ECHO_AT_END: Final = re.compile(
    rb"(?:VV|PP|II|BM|QT|RS|RT|TM[012]|SS\d{6}|CR\d\d|HS[01]|(?:MD|MS)\d{13}|(?:GD|GS)\d{10}|SCIP2\.0)"
    rb"(?:;[A-Za-z0-9 ._+@]{0,16})?\Z"
)


def set_baud(baud: int) -> str:
    """Return the command SS for this bit rate."""
    return f"SS{baud:06d}"


@dataclass(frozen=True, slots=True)
class ScanRequest:
    """A request for ranges: MD and MS for continuous scans, GD and GS for the latest; G is that of SCIP 1.1.

    D stands for values of three characters, S (and G) for two. Steps are counted as the sensor does, 1024 per turn.
    """

    letters: str
    first: int
    last: int
    cluster: int = 1
    """Steps that share one value, their least range; 0 means 1."""
    interval: int = 0
    """Scans left out between two that are sent."""
    scans: int = 0
    """Number of scans to send, 0 until QT; in the answer, the number still to come."""

    @property
    def width(self) -> int:
        """Characters per value."""
        return 3 if self.letters in ("MD", "GD") else 2

    @property
    def continuous(self) -> bool:
        """True for continuous scans."""
        return self.letters in ("MD", "MS")

    @property
    def values(self) -> int:
        """Number of values in one scan."""
        return -((self.first - self.last - 1) // max(self.cluster, 1))

    def encode(self) -> str:
        """Return the command, without the line feed."""
        if self.letters == "G":
            return f"G{self.first:03d}{self.last:03d}{self.cluster:02d}"
        tail = f"{self.interval:d}{self.scans:02d}" if self.continuous else ""
        return f"{self.letters}{self.first:04d}{self.last:04d}{self.cluster:02d}{tail}"

    @classmethod
    def decode(cls, text: str) -> ScanRequest:
        """Read a command or its echo; DecodeError for any other."""
        text = without_note(text)
        if found := _CONTINUOUS.fullmatch(text) or _LATEST.fullmatch(text):
            return cls(found[1], *map(int, found.groups()[1:]))
        if found := _OLD.fullmatch(text):
            return cls("G", *map(int, found.groups()))
        raise DecodeError(f"{text!r} asks for no ranges")


def without_note(text: str) -> str:
    """Return the command without the note that a client appended to it."""
    return _NOTE.sub("", text) if ";" in text else text


def note_of(text: str) -> str:
    """Return the note that a client appended to the command, with its semicolon; empty if there is none."""
    found = _NOTE.search(text)
    return found[0] if found else ""


def echo_at_end(line: bytes) -> bytes | None:
    """Return the echo of a command that ends this line, after damage that joined two answers."""
    found = _ECHO_AT_END.search(line)
    return found[0] if found else None
