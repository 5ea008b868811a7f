"""Lists of words, as people write them in Python."""

from __future__ import annotations

from collections.abc import Iterable


def texts(given: str | Iterable[str]) -> tuple[str, ...]:
    """Several texts; a bare string is a list of one, and not of its letters."""
    return (given,) if isinstance(given, str) else tuple(given)
