"""One answer of the sensor: the echo of the command, a status, lines of data, and an empty line."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from hardware import DecodeError
from hardware.scip.commands import TO_SCIP2, echo_at_end, without_note
from hardware.scip.encoding import add_sum, check_sum

DATA_LINE: Final = 64
"""Characters of data in a full line."""
_INFORMATION: Final = ("VV", "PP", "II")
"""Commands whose answers are lines ``KEY:value;``."""


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer with correct sums, which are removed.

    A status of one character is that of SCIP 1.1, which has no sums.
    """

    echo: str
    status: str
    lines: tuple[bytes, ...] = ()

    def encode(self) -> bytes:
        """Return the bytes on the wire, including the empty line at the end."""
        status, lines = self.status.encode("latin-1"), self.lines
        if len(status) > 1:
            status, lines = add_sum(status), tuple(add_sum(line, _informs(self.echo)) for line in lines)
        return b"\n".join([self.echo.encode("latin-1"), status, *lines, b"", b""])


def data_lines(data: bytes) -> tuple[bytes, ...]:
    """Cut data into lines."""
    return tuple(data[i : i + DATA_LINE] for i in range(0, len(data), DATA_LINE))


def decode_reply(lines: tuple[bytes, ...]) -> Reply:
    """Read an answer of SCIP 2.0 from its lines; DecodeError for anything else."""
    if len(lines) < 2:
        raise DecodeError("no status")
    echo = _text(lines[0])
    if echo == TO_SCIP2 and len(lines) == 2 and len(lines[1]) == 1:
        return Reply(echo, _text(lines[1]))
    if len(lines[1]) != 3:
        raise DecodeError(f"status of {len(lines[1])} characters")
    return Reply(echo, _text(check_sum(lines[1])), tuple(check_sum(line, _informs(echo)) for line in lines[2:]))


def decode_old_reply(lines: tuple[bytes, ...]) -> Reply:
    """Read an answer of SCIP 1.1 from its lines, which have no sums; DecodeError for anything else."""
    if len(lines) < 2 or len(lines[1]) != 1:
        raise DecodeError("no status of one character")
    return Reply(_text(lines[0]), _text(lines[1]), lines[2:])


def possible_replies(lines: tuple[bytes, ...]) -> Iterator[tuple[bytes, ...]]:
    """Yield the possible answers among the lines between two empty lines.

    If an empty line was damaged, the remains of another answer come first. So an answer may begin at the first line, or
    wherever a line ends with the echo of a command.
    """
    yield lines
    for start, line in enumerate(lines):
        echo = echo_at_end(line)
        if echo is not None and (start or echo != line):
            yield (echo, *lines[start + 1 :])


def find_reply(lines: tuple[bytes, ...]) -> Reply | None:
    """Return the answer of SCIP 2.0 among the lines between two empty lines; None if there is none."""
    for answer in possible_replies(lines):
        with suppress(DecodeError):
            return decode_reply(answer)
    return None


def _informs(echo: str) -> bool:
    return without_note(echo) in _INFORMATION


def _text(line: bytes) -> str:
    if not (line.isascii() and line.decode("ascii").isprintable()):
        raise DecodeError("characters that are not text")
    return line.decode("ascii")
