"""The colours of all pictures of a run: one for each thing, the same everywhere."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Palette:
    """Colours as matplotlib takes them."""

    ink: str = "#1f2328"
    faint: str = "#8b949e"
    grid: str = "#eaecef"
    solid: str = "#e0e0e0"
    """Of the true walls ..."""
    edge: str = "#c2c6cb"
    """... and their edges."""
    wall: str = "#1f2328"
    """Of the walls and segments that were mapped."""
    point: str = "#b48ead"
    slam: str = "#0a7d5a"
    odometry: str = "#d1495b"
    truth: str = "#1f2328"
    accent: str = "#2f6fb0"


PAPER = Palette()
"""Dark on white."""
