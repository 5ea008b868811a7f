"""The character that ends a line of SCIP 2.0: a sum over the line in six bits.

Every character of a line counts: in lines of data the semicolon is the digit 11. Only the semicolon that ends a
``KEY:value;`` line of VV, PP and II is left out.
"""

from __future__ import annotations

from hardware.decode_error import DecodeError


def line_sum(text: bytes) -> int:
    """The sum as the character that stands for it."""
    return (sum(text) & 0x3F) + 0x30


def seal(line: bytes) -> bytes:
    """The line with its sum."""
    return line + bytes([line_sum(line)])


def seal_entry(entry: bytes) -> bytes:
    """The line ``KEY:value;`` with its sum, in which the last semicolon does not count."""
    return entry + bytes([line_sum(entry.removesuffix(b";"))])


def unseal(line: bytes) -> bytes:
    """The line without its sum; Damaged when the sum is another one."""
    text = _without_sum(line)
    if line[-1] != line_sum(text):
        raise DecodeError("sum")
    return text


def unseal_entry(line: bytes) -> bytes:
    """The line ``KEY:value;`` without its sum; Damaged when the sum is another one.

    Some sensors sum the semicolon too.
    """
    text = _without_sum(line)
    if line[-1] not in (line_sum(text), line_sum(text.removesuffix(b";"))):
        raise DecodeError("sum")
    return text


def _without_sum(line: bytes) -> bytes:
    if not line:
        raise DecodeError("an empty line has no sum")
    return line[:-1]
