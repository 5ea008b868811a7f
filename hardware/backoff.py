"""Pauses between attempts, each longer than the one before."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Final

_FIRST: Final = 0.1
_LONGEST: Final = 2.0


class Backoff:
    """Iterate for one attempt after each pause, of 0.1 s up to 2 s; it ends when ``closing`` is set."""

    def __init__(self, closing: threading.Event) -> None:
        self._closing = closing

    def __iter__(self) -> Iterator[None]:
        pause = _FIRST
        while not self._closing.wait(pause):
            yield
            pause = min(2.0 * pause, _LONGEST)
