"""The character that ends a line of SCIP 2.0: a sum over the line in six bits."""

from __future__ import annotations

from hardware.damaged import Damaged


def line_sum(text: bytes) -> int:
    """The sum as the character that stands for it."""
    return (sum(text) & 0x3F) + 0x30


def seal(line: bytes) -> bytes:
    """The line with its sum, over which the semicolon after ``KEY:value`` does not count."""
    return line + bytes([line_sum(line.removesuffix(b";"))])


def unseal(line: bytes) -> bytes:
    """The line without its sum; Damaged when the sum is another one. Some sensors sum the semicolon too."""
    if not line:
        raise Damaged("an empty line has no sum")
    text, found = line[:-1], line[-1]
    if found != line_sum(text) and not (text.endswith(b";") and found == line_sum(text[:-1])):
        raise Damaged("sum")
    return text
