"""What a run keeps in its folder besides its traces, its map and its metrics."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Keep:
    """By default all there is; one of many runs leaves out what nobody will look at."""

    pictures: bool = True
    """``map.png`` and ``errors.png``."""
